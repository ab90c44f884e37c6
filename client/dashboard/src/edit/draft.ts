// SPDX-License-Identifier: Apache-2.0
import type { MapEdit } from '../gen/enfilade/v1/map_edit_pb';
import type { Value } from './cells';
import { Layer } from './layers';
import { masked, Overlay } from './overlay';
import { rasterised } from './raster/raster';
import type { Spans } from './raster/spans';

export interface Entry {
  // As the server has it, or as it was drawn.
  edit: MapEdit;
  layer: Layer;
  // Of the draft when the server last changed it; 0n: the server has not got it yet.
  head: bigint;
  // By the server; what is shown may be ahead of it.
  stored: boolean;
}

// The order of what the server has not got yet: after all that it has.
const PENDING = 2 ** 50;

const isPending = ({ order }: Layer) => order >= PENDING;

// The edits of a draft: those of the server in its order, and over them those that are on their way to it.
export class Draft {
  readonly entries = new Map<string, Entry>();
  // All that the server had changed up to this head is known here.
  head = 0n;
  // The highest head of any edit.
  newest = 0n;
  // By edit: how many switches on or off are on their way, and what the last one says.
  private readonly switches = new Map<string, { count: number; active: boolean }>();
  private drawn = 0;

  constructor(readonly overlay = new Overlay()) {}

  // What the server says of edits. Older news than is known changes nothing.
  take(edits: readonly MapEdit[]) {
    for (const edit of edits) {
      const known = this.entries.get(edit.editId);
      if (known && edit.head < known.head) continue;
      if (edit.head > this.newest) this.newest = edit.head;
      const active = this.switches.get(edit.editId)?.active ?? edit.active;
      const layer = new Layer(edit.editId, spansOf(edit, known), edit.value as Value, Number(edit.sequence), active);
      this.overlay.replace(known?.layer, layer);
      this.entries.set(edit.editId, { edit, layer, head: edit.head, stored: edit.active });
    }
  }

  // Draws an edit before the server has it. `spans`: its cells; what depends on the picture is shown as it is known here.
  draw(edit: MapEdit, spans = this.cellsOf(edit)) {
    if (this.entries.has(edit.editId)) return;
    const layer = new Layer(edit.editId, spans, edit.value as Value, PENDING + this.drawn++, true);
    this.overlay.add(layer);
    this.entries.set(edit.editId, { edit, layer, head: 0n, stored: true });
  }

  // Switches edits on or off before the server has done so: until `settle` is called with the same ones.
  setActive(ids: readonly string[], active: boolean) {
    for (const id of ids) {
      this.switches.set(id, { count: (this.switches.get(id)?.count ?? 0) + 1, active });
      this.show(id, active);
    }
  }

  // The server has done what `setActive` asked for, and its answer was taken; or it has refused.
  settle(ids: readonly string[]) {
    for (const id of ids) {
      const { count, active } = this.switches.get(id) ?? { count: 1, active: true };
      if (count > 1) {
        this.switches.set(id, { count: count - 1, active });
        continue;
      }
      this.switches.delete(id);
      const entry = this.entries.get(id);
      if (entry) this.show(id, entry.stored);
    }
  }

  // An edit that the server refuses, or all that it has not got.
  drop(id: string) {
    const entry = this.entries.get(id);
    if (!entry || entry.head > 0n) return;
    this.overlay.remove(entry.layer);
    this.entries.delete(id);
    this.switches.delete(id);
  }

  isActive = (id: string) => this.entries.get(id)?.layer.active ?? false;

  // Of a tile as the server has it, without what is on its way.
  storedDigest(row: number, column: number): string {
    const { layers } = this.overlay.tile(row, column);
    if (!layers.some((layer) => isPending(layer) || this.switches.has(layer.id))) return this.overlay.digest(row, column);
    const stored = layers.filter((layer) => !isPending(layer)).map((layer) => {
      const active = this.entries.get(layer.id)?.stored ?? layer.active;
      return active === layer.active ? layer : new Layer(layer.id, layer.spans, layer.value, layer.order, active);
    });
    return this.overlay.digestWith(row, column, stored);
  }

  // Of an edit that is not drawn yet.
  cellsOf(edit: MapEdit): Spans {
    const all = rasterised(edit.shape);
    return edit.onlyWhere.length === 0 ? all : masked(this.overlay, all, edit.onlyWhere);
  }

  private show(id: string, active: boolean) {
    const entry = this.entries.get(id);
    if (!entry || entry.layer.active === active) return;
    const { spans, value, order } = entry.layer;
    const layer = new Layer(id, spans, value, order, active);
    this.overlay.replace(entry.layer, layer);
    entry.layer = layer;
  }
}

// An edit's cells never change; only what depends on the picture is a patch once the server has it.
function spansOf(edit: MapEdit, known: Entry | undefined): Spans {
  const isSame = known !== undefined && known.edit.shape.case === edit.shape.case && (known.head > 0n || known.edit.onlyWhere.length === 0);
  return isSame ? known.layer.spans : rasterised(edit.shape);
}
