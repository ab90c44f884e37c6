// SPDX-License-Identifier: Apache-2.0
import type { Client } from '@connectrpc/connect';
import { problemOf } from '../api/errors';
import type { MapDraftTile, MapEditService } from '../gen/enfilade/v1/map_edit_service_pb';
import { TILE, tileKey, UNITS, type Box, type Units } from './lattice';

const AT_ONCE = 16; // tiles of a call
const CALLS = 2;
const RETRY_MS = 2000;

export interface TileEvents {
  // `head`: of the draft that the tile shows.
  tile(tile: MapDraftTile, head: bigint): void;
  // The map's cells are known.
  box(box: Box | undefined): void;
  failed(text: string | undefined): void;
}

// Reads all tiles of a draft, those first that are near to what the person looks at.
export class TileReader {
  focus: Units = { x: 0, y: 0 };
  private readonly wanted = new Map<number, { row: number; column: number }>();
  private readonly known = new Map<number, { row: number; column: number }>();
  private calls = 0;
  // Tiles that were asked for before the map's published edits changed are asked for again.
  private generation = 0;
  private isListed = false;
  private stopped = false;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(private readonly draft: string, private readonly service: Pick<Client<typeof MapEditService>, 'readMapDraftTiles'>, private readonly events: TileEvents) {}

  get idle(): boolean {
    return this.isListed && this.calls === 0 && this.wanted.size === 0;
  }
  // How many tiles there are, and how many of them are still to come.
  get progress(): { all: number; left: number } {
    return { all: this.known.size, left: this.isListed ? this.wanted.size : this.known.size };
  }

  // Which tiles there are, and then all of them.
  async list(): Promise<void> {
    ++this.calls;
    try {
      const { box, knownTiles } = await this.service.readMapDraftTiles({ name: this.draft, tiles: [] });
      this.isListed = true;
      this.events.box(box);
      this.events.failed(undefined);
      for (const { row, column } of knownTiles) this.want(row, column);
    } catch (error) {
      this.retry(error, () => void this.list());
    } finally {
      --this.calls;
    }
    this.pump();
  }

  want(row: number, column: number) {
    const key = tileKey(row, column);
    this.wanted.set(key, { row, column });
    this.known.set(key, { row, column });
    if (this.isListed) this.pump();
  }

  // All that is here is out of date.
  again() {
    ++this.generation;
    for (const [key, place] of this.known) this.wanted.set(key, place);
    void this.list();
  }

  close() {
    this.stopped = true;
    clearTimeout(this.timer);
  }

  private nearest(): { row: number; column: number }[] {
    const middle = { x: this.focus.x / UNITS / TILE - 0.5, y: this.focus.y / UNITS / TILE - 0.5 };
    const distance = ({ row, column }: { row: number; column: number }) => (row - middle.y) ** 2 + (column - middle.x) ** 2;
    return [...this.wanted.values()].sort((a, b) => distance(a) - distance(b)).slice(0, AT_ONCE);
  }

  private pump() {
    while (!this.stopped && this.calls < CALLS && this.wanted.size > 0) {
      const tiles = this.nearest();
      for (const { row, column } of tiles) this.wanted.delete(tileKey(row, column));
      void this.read(tiles);
    }
  }

  private async read(tiles: { row: number; column: number }[]) {
    ++this.calls;
    const { generation } = this;
    try {
      const answer = await this.service.readMapDraftTiles({ name: this.draft, tiles });
      if (this.stopped) return;
      this.events.failed(undefined);
      for (const tile of answer.tiles) if (generation === this.generation || !this.wanted.has(tileKey(tile.row, tile.column))) this.events.tile(tile, answer.head);
    } catch (error) {
      for (const { row, column } of tiles) this.wanted.set(tileKey(row, column), { row, column });
      this.retry(error, () => this.pump());
      return;
    } finally {
      --this.calls;
    }
    this.pump();
  }

  private retry(error: unknown, act: () => void) {
    if (this.stopped) return;
    this.events.failed(problemOf(error).text);
    clearTimeout(this.timer);
    this.timer = setTimeout(act, RETRY_MS);
  }
}
