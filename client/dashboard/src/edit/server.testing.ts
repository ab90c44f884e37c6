// SPDX-License-Identifier: Apache-2.0
// The server's part of a draft as map_edit_service.proto says it, in memory: for tests of what happens when answers are lost.
import { create } from '@bufbuild/protobuf';
import { Code, ConnectError } from '@connectrpc/connect';
import { sha256 } from '@noble/hashes/sha2.js';
import type { MapEdit } from '../gen/enfilade/v1/map_edit_pb';
import { AppendMapEditsResponseSchema, MapEditTileSchema, type AppendMapEditsResponse, type MapEditTile } from '../gen/enfilade/v1/map_edit_service_pb';
import { CLEAR } from './cells';
import { placeOf, TILE } from './lattice';
import { rasterised } from './raster/raster';
import { tilesOf, visitWithin } from './raster/spans';
import type { Calls } from './sync/outbox';

export class DraftServer {
  readonly edits: MapEdit[] = [];
  head = 0n;
  calls = 0;
  // Before a call is done, and before it is answered.
  before: () => void = () => {};
  after: () => void = () => {};
  refuses: (edit: MapEdit) => boolean = () => false;

  readonly service: Calls = {
    appendMapEdits: async ({ edits = [], knownHead = 0n }) => this.answer(knownHead, () => {
      for (const edit of edits as MapEdit[]) if (this.refuses(edit)) throw new ConnectError(`edit ${edit.editId} is refused`, Code.InvalidArgument);
      const fresh = (edits as MapEdit[]).filter(({ editId }) => !this.edits.some((known) => known.editId === editId));
      for (const edit of fresh) this.edits.push({ ...edit, sequence: BigInt(this.edits.length + 1), active: true, head: this.head + 1n });
      if (fresh.length > 0) ++this.head;
      return (edits as MapEdit[]).map(({ editId }) => editId);
    }),
    // The answers of both have the same fields.
    setMapEditsActive: (async ({ editIds = [], active = false, author = '', knownHead = 0n }: { editIds?: string[]; active?: boolean; author?: string; knownHead?: bigint }) => this.answer(knownHead, () => {
      const meant = editIds.map((id) => this.edits.find(({ editId }) => editId === id));
      if (meant.some((edit) => edit === undefined)) throw new ConnectError('no such edit', Code.NotFound);
      if (meant.some((edit) => edit!.author !== author)) throw new ConnectError('an edit of another author', Code.FailedPrecondition);
      const changed = meant.filter((edit) => edit!.active !== active);
      if (changed.length > 0) ++this.head;
      for (const edit of changed) Object.assign(edit!, { active, head: this.head });
      return editIds;
    })) as unknown as Calls['setMapEditsActive'],
  };

  since(head: bigint): MapEdit[] {
    return this.edits.filter((edit) => edit.head > head).sort((a, b) => Number(a.head - b.head)).map((edit) => ({ ...edit }));
  }

  tile(row: number, column: number): MapEditTile {
    const cells = new Uint8Array(TILE * TILE);
    for (const { shape, value, active } of this.edits) {
      if (!active) continue;
      visitWithin(rasterised(shape), row * TILE, (row + 1) * TILE, column * TILE, (column + 1) * TILE, (y, begin, end) => {
        const base = (y - row * TILE) * TILE - column * TILE;
        cells.fill((value as number) === CLEAR ? 0 : value, base + begin, base + end);
      });
    }
    return create(MapEditTileSchema, { row, column, sha256: sha256(cells) });
  }

  private answer(knownHead: bigint, act: () => string[]): AppendMapEditsResponse {
    ++this.calls;
    this.before();
    const ids = act();
    const known = knownHead === 0n ? this.edits.filter(({ editId }) => ids.includes(editId)).map((edit) => ({ ...edit })) : this.since(knownHead);
    const keys = new Set(this.edits.filter(({ editId }) => ids.includes(editId)).flatMap(({ shape }) => [...tilesOf(rasterised(shape))]));
    const tiles = [...keys].map(placeOf).map(({ row, column }) => this.tile(row, column));
    this.after();
    return create(AppendMapEditsResponseSchema, { head: this.head, edits: known, tiles });
  }
}
