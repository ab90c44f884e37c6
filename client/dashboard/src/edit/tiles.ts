// SPDX-License-Identifier: Apache-2.0
import type { Client } from '@connectrpc/connect';
import { problemOf } from '../api/errors';
import type { MapDraftTile, MapEditService } from '../gen/enfilade/v1/map_edit_service_pb';
import { TILE, tileKey, UNITS, type Box, type Units } from './lattice';

const AT_ONCE = 16; // tiles of a call
const CALLS = 2;
const RETRY_MS = 2000;
// While robots map, a map may have a new revision each second.
const RENEW_MS = 3000;

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
  // Tiles that were asked for before the map changed are asked for again.
  private generation = 0;
  // Which tiles there are is known as of this one.
  private listed = -1;
  private hadAll = false;
  private stopped = false;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private renewing: ReturnType<typeof setTimeout> | undefined;
  private renewed = -Infinity;

  constructor(private readonly draft: string, private readonly service: Pick<Client<typeof MapEditService>, 'readMapDraftTiles'>, private readonly events: TileEvents) {}

  get idle(): boolean {
    return this.isListed && this.calls === 0 && this.wanted.size === 0 && this.renewing === undefined;
  }
  // How many tiles there are, and how many of them are still to come. Those that are read anew are there.
  get progress(): { all: number; left: number } {
    return { all: this.known.size, left: this.hadAll ? 0 : this.isListed ? this.wanted.size : this.known.size };
  }
  private get isListed(): boolean {
    return this.listed === this.generation;
  }

  // Which tiles there are, and then all of them.
  async list(): Promise<void> {
    ++this.calls;
    const { generation } = this;
    try {
      const { box, knownTiles } = await this.service.readMapDraftTiles({ name: this.draft, tiles: [] });
      if (this.stopped || generation !== this.generation) return;
      this.listed = generation;
      this.events.box(box);
      this.events.failed(undefined);
      for (const { row, column } of knownTiles) this.known.set(tileKey(row, column), { row, column });
      for (const [key, place] of this.known) this.wanted.set(key, place);
    } catch (error) {
      this.retry(error);
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
    clearTimeout(this.renewing);
    this.renewing = undefined;
    this.renewed = Date.now();
    ++this.generation;
    void this.list();
  }

  // What robots have seen may be: as `again`, when all that was wanted has come, and not more often than each few seconds.
  renew() {
    this.renewing ??= setTimeout(() => {
      this.renewing = undefined;
      if (this.stopped) return;
      if (this.idle) this.again();
      else this.renew();
    }, Math.max(100, this.renewed + RENEW_MS - Date.now()));
  }

  close() {
    this.stopped = true;
    clearTimeout(this.timer);
    clearTimeout(this.renewing);
  }

  private nearest(): { row: number; column: number }[] {
    const middle = { x: this.focus.x / UNITS / TILE - 0.5, y: this.focus.y / UNITS / TILE - 0.5 };
    const distance = ({ row, column }: { row: number; column: number }) => (row - middle.y) ** 2 + (column - middle.x) ** 2;
    return [...this.wanted.values()].sort((a, b) => distance(a) - distance(b)).slice(0, AT_ONCE);
  }

  private pump() {
    this.hadAll ||= this.idle;
    while (!this.stopped && this.isListed && this.calls < CALLS && this.wanted.size > 0) {
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
      // Those of before are asked for again: this answer may come after the new one.
      if (generation === this.generation) for (const tile of answer.tiles) this.events.tile(tile, answer.head);
    } catch (error) {
      for (const { row, column } of tiles) this.wanted.set(tileKey(row, column), { row, column });
      this.retry(error);
      return;
    } finally {
      --this.calls;
    }
    this.pump();
  }

  private retry(error: unknown) {
    if (this.stopped) return;
    this.events.failed(problemOf(error).text);
    clearTimeout(this.timer);
    this.timer = setTimeout(() => (this.isListed ? this.pump() : void this.list()), RETRY_MS);
  }
}
