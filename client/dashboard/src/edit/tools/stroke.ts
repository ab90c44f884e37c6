// SPDX-License-Identifier: Apache-2.0
import { Layer } from '../layers';
import type { Units } from '../lattice';
import { masked } from '../overlay';
import { addSegment } from '../raster/brush';
import { SpanList } from '../raster/spans';
import type { EditSession } from '../session';
import { brushEdits, inMiddle, type Style } from '../shapes';
import { radiusOf, type Settings } from './settings';

// What the pointer's way so far has, over everything else.
const UPPERMOST = Infinity;

// Of the radius: steps that are shorter change nothing that is seen.
const NEAR = 1 / 64;

// A brush on its way. Each part is painted when the pointer has passed it, and the whole becomes an edit at the end.
export class Stroke {
  private readonly points: Units[] = [];
  private readonly layers: Layer[] = [];
  private readonly radius: number;

  constructor(private readonly session: EditSession, private readonly settings: Settings, private readonly style: Style) {
    this.radius = radiusOf(settings);
  }

  to(at: Units) {
    const point = this.settings.size === 1 ? inMiddle(at) : at;
    const before = this.points.at(-1);
    if (before && Math.hypot(before.x - point.x, before.y - point.y) <= this.radius * NEAR) return;
    this.points.push(point);
    const list = new SpanList();
    addSegment(list, before ?? point, point, this.radius);
    const all = list.take();
    const { overlay } = this.session.draft;
    const { onlyWhere, value } = this.style;
    const layer = new Layer('', onlyWhere.length === 0 ? all : masked(overlay, all, onlyWhere), value, UPPERMOST, true);
    this.layers.push(layer);
    overlay.add(layer);
  }

  // Returns why it has become nothing.
  end(): string | undefined {
    const { overlay } = this.session.draft;
    const edits = brushEdits(this.style, this.points, this.radius);
    if (edits.length > 1) {
      overlay.removeAll(this.layers, true);
      return this.session.add(edits);
    }
    const list = new SpanList();
    for (const { spans } of this.layers) for (let i = 0; i < spans.length; i += 3) list.add(spans[i]!, spans[i + 1]!, spans[i + 2]!);
    const problem = this.session.add(edits, list.take());
    // The edit looks the same.
    overlay.removeAll(this.layers, problem !== undefined);
    return problem;
  }

  cancel() {
    this.session.draft.overlay.removeAll(this.layers, true);
  }
}
