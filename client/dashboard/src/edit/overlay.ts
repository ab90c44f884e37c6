// SPDX-License-Identifier: Apache-2.0
import { CLEAR, digestOf, shownOf, type Value } from './cells';
import { insert, type Layer } from './layers';
import { placeOf, TILE, tileKey, tileOf } from './lattice';
import { TILE_CELLS, visitWithin, type Spans } from './raster/spans';

export interface Tile {
  readonly row: number;
  readonly column: number;
  // What robots have seen and what is published are those of the server. Until then nothing is known of the tile.
  loaded: boolean;
  readonly cells: Uint8Array;
  // In their order.
  readonly layers: Layer[];
}

// Cells of a tile, from the first to before the end.
interface Rect {
  firstRow: number;
  endRow: number;
  firstColumn: number;
  endColumn: number;
}

const WHOLE: Rect = { firstRow: 0, endRow: TILE, firstColumn: 0, endColumn: TILE };

// A map's cells under the edits of a draft. A cell has the value of the highest active layer that covers it, else what is
// published.
export class Overlay {
  readonly tiles = new Map<number, Tile>();

  // `touched`: cells of a tile may have changed. `missing`: a tile has been edited that is not loaded.
  constructor(private readonly touched: (tile: Tile, firstRow: number, endRow: number, firstColumn: number, endColumn: number) => void = () => {},
              private readonly missing: (row: number, column: number) => void = () => {}) {}

  tile(row: number, column: number): Tile {
    const key = tileKey(row, column);
    let tile = this.tiles.get(key);
    if (!tile) this.tiles.set(key, (tile = { row, column, loaded: false, cells: new Uint8Array(TILE_CELLS), layers: [] }));
    return tile;
  }

  // The byte of a cell.
  at(row: number, column: number): number {
    const tile = this.tiles.get(tileKey(tileOf(row), tileOf(column)));
    return tile ? tile.cells[(row - TILE * tile.row) * TILE + column - TILE * tile.column]! : 0;
  }

  // Takes what robots have seen and what is published from the server's cells, and lays the layers over it.
  load(row: number, column: number, cells: Uint8Array) {
    const tile = this.tile(row, column);
    tile.loaded = true;
    for (let i = 0; i < TILE_CELLS; ++i) tile.cells[i] = cells[i]! & 0b110011;
    this.renew(tile, WHOLE);
  }

  // Takes all from the server's cells, for a tile that is otherwise wrong.
  trust(row: number, column: number, cells: Uint8Array) {
    const tile = this.tile(row, column);
    tile.cells.set(cells);
    this.touched(tile, 0, TILE, 0, TILE);
  }

  add(layer: Layer) {
    for (const key of layer.tiles) {
      const tile = this.tileOfKey(key);
      const above = insert(tile.layers, layer);
      if (!layer.active) continue;
      if (above === 0) this.paintOnto(tile, layer);
      else this.renew(tile, rectOf(tile, layer));
    }
  }

  remove(layer: Layer) {
    for (const key of layer.tiles) {
      const tile = this.tiles.get(key);
      const at = tile?.layers.indexOf(layer) ?? -1;
      if (!tile || at < 0) continue;
      tile.layers.splice(at, 1);
      if (layer.active) this.renew(tile, rectOf(tile, layer));
    }
  }

  // At once; `repaint`: what they cover may look otherwise without them.
  removeAll(layers: readonly Layer[], repaint: boolean) {
    const gone = new Set(layers);
    const rects = new Map<Tile, Rect>();
    for (const layer of layers) {
      for (const key of layer.tiles) {
        const tile = this.tiles.get(key)!;
        rects.set(tile, around(rects.get(tile), rectOf(tile, layer)));
      }
    }
    for (const [tile, rect] of rects) {
      const left = tile.layers.filter((layer) => !gone.has(layer));
      tile.layers.splice(0, tile.layers.length, ...left);
      if (repaint) this.renew(tile, rect);
    }
  }

  // In the place of another one: where nothing changes by it, nothing is painted.
  replace(before: Layer | undefined, after: Layer) {
    if (before && before.spans === after.spans && before.value === after.value && before.active === after.active && this.exchange(before, after)) return;
    if (before) this.remove(before);
    this.add(after);
  }

  // As MapEditTile.sha256.
  digest(row: number, column: number): string {
    return digestOf(this.tile(row, column).cells);
  }

  // The same with other layers than the tile has.
  digestWith(row: number, column: number, layers: Layer[]): string {
    const tile = this.tile(row, column);
    const other: Tile = { ...tile, cells: tile.cells.slice(), layers };
    compose(other, WHOLE);
    return digestOf(other.cells);
  }

  // Whether the order among the others stays the same; if so the one has the other's place.
  private exchange(before: Layer, after: Layer): boolean {
    const places: [Tile, number][] = [];
    for (const key of before.tiles) {
      const tile = this.tiles.get(key);
      const at = tile?.layers.indexOf(before) ?? -1;
      if (!tile || at < 0) return false;
      if ((tile.layers[at - 1]?.order ?? -Infinity) > after.order || (tile.layers[at + 1]?.order ?? Infinity) < after.order) return false;
      places.push([tile, at]);
    }
    for (const [tile, at] of places) tile.layers[at] = after;
    return true;
  }

  private tileOfKey(key: number): Tile {
    const known = this.tiles.get(key);
    if (known) return known;
    const { row, column } = placeOf(key);
    this.missing(row, column);
    return this.tile(row, column);
  }

  private paintOnto(tile: Tile, layer: Layer) {
    const rect = rectOf(tile, layer);
    paint(tile, rect, layer.spans, layer.value);
    this.touched(tile, rect.firstRow, rect.endRow, rect.firstColumn, rect.endColumn);
  }

  private renew(tile: Tile, rect: Rect) {
    compose(tile, rect);
    this.touched(tile, rect.firstRow, rect.endRow, rect.firstColumn, rect.endColumn);
  }
}

// The layer's box within the tile, in cells of the tile.
function rectOf(tile: Tile, layer: Layer): Rect {
  const { firstRow, firstColumn, width, height } = layer.box!;
  const [top, left] = [firstRow - TILE * tile.row, firstColumn - TILE * tile.column];
  return { firstRow: Math.max(0, top), endRow: Math.min(TILE, top + height), firstColumn: Math.max(0, left), endColumn: Math.min(TILE, left + width) };
}

function around(a: Rect | undefined, b: Rect): Rect {
  if (!a) return b;
  return {
    firstRow: Math.min(a.firstRow, b.firstRow), endRow: Math.max(a.endRow, b.endRow),
    firstColumn: Math.min(a.firstColumn, b.firstColumn), endColumn: Math.max(a.endColumn, b.endColumn),
  };
}

function paint(tile: Tile, rect: Rect, spans: Spans, value: Value) {
  const [row0, column0] = [TILE * tile.row, TILE * tile.column];
  const bits = (value === CLEAR ? 0 : value) << 2;
  const { cells } = tile;
  visitWithin(spans, row0 + rect.firstRow, row0 + rect.endRow, column0 + rect.firstColumn, column0 + rect.endColumn, (row, begin, end) => {
    const base = (row - row0) * TILE - column0;
    for (let i = base + begin; i < base + end; ++i) cells[i] = (cells[i]! & 0b110011) | bits;
  });
}

// From what is published up.
function compose(tile: Tile, rect: Rect) {
  const { cells } = tile;
  for (let row = rect.firstRow; row < rect.endRow; ++row) {
    const end = row * TILE + rect.endColumn;
    for (let i = row * TILE + rect.firstColumn; i < end; ++i) cells[i] = (cells[i]! & 0b110011) | ((cells[i]! & 0b110000) >> 2);
  }
  for (const { active, spans, value } of tile.layers) if (active) paint(tile, rect, spans, value);
}

// Those of the cells that show one of `classes` now.
export function masked(overlay: Overlay, spans: Spans, classes: readonly number[]): Spans {
  const kept: number[] = [];
  for (let i = 0; i < spans.length; i += 3) {
    const row = spans[i]!;
    let begin: number | undefined;
    for (let column = spans[i + 1]!; column <= spans[i + 2]!; ++column) {
      if (column < spans[i + 2]! && classes.includes(shownOf(overlay.at(row, column)))) {
        begin ??= column;
      } else if (begin !== undefined) {
        kept.push(row, begin, column);
        begin = undefined;
      }
    }
  }
  return Int32Array.from(kept);
}
