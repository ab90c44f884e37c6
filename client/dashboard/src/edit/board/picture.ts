// SPDX-License-Identifier: Apache-2.0
// The tiles as pictures. Zoomed out, a pixel stands for several cells: occupied wins, else free, so that thin walls stay.
import { editedOf, OCCUPIED, publishedOf, shownOf, UNKNOWN } from '../cells';
import type { Camera, Size } from '../../scene/camera';
import { TILE, tileKey } from '../lattice';
import type { Tile } from '../overlay';
import { strongest } from './strongest';

interface Rect {
  x0: number;
  y0: number;
  x1: number;
  y1: number;
}

// A tile at one zoom, whose pixels stand for 2^level cells.
interface Level {
  canvas: HTMLCanvasElement;
  context: CanvasRenderingContext2D;
  // Cells of the tile that have changed since it was painted.
  stale: Rect | undefined;
  usedIn: number;
}

const TOP = 8; // one pixel for a tile
const MAX_PIXELS = 24e6;
// Of a frame, for painting tiles; the rest is painted in the next ones.
const BUDGET_MS = 6;

export class Picture {
  // As the words of ImageData, for the 64 values of a cell.
  colours: Uint32Array = new Uint32Array(64);
  private readonly levels = new Map<number, (Level | undefined)[]>();
  private pixels = 0;
  private frame = 0;
  drawn = 0;

  constructor(private readonly tiles: ReadonlyMap<number, Tile>) {}

  touch({ row, column }: Tile, y0: number, y1: number, x0: number, x1: number) {
    for (const level of this.levels.get(tileKey(row, column)) ?? []) {
      if (!level) continue;
      const { stale } = level;
      level.stale = stale ? { x0: Math.min(x0, stale.x0), y0: Math.min(y0, stale.y0), x1: Math.max(x1, stale.x1), y1: Math.max(y1, stale.y1) } : { x0, y0, x1, y1 };
    }
  }

  // All anew, with other colours.
  touchAll() {
    this.levels.clear();
    this.pixels = 0;
  }

  // Camera in cells, pixels of the device. Returns whether all is up to date.
  draw(context: CanvasRenderingContext2D, camera: Camera, size: Size): boolean {
    ++this.frame;
    this.drawn = 0;
    const wanted = Math.min(TOP, Math.max(0, Math.ceil(Math.log2(1 / camera.scale) - 1e-9)));
    const end = performance.now() + BUDGET_MS;
    let isComplete = true;
    context.imageSmoothingEnabled = false;
    for (const tile of this.seen(camera, size)) {
      const isLate = performance.now() > end;
      const level = this.best(tile, wanted, isLate);
      if (!level) {
        isComplete = false;
        continue;
      }
      if (level.stale || level.canvas.width !== TILE >> wanted) isComplete = false;
      // Whole pixels, so that there are no seams.
      const x0 = Math.round(size.width / 2 + (tile.column * TILE - camera.x) * camera.scale);
      const x1 = Math.round(size.width / 2 + ((tile.column + 1) * TILE - camera.x) * camera.scale);
      const y0 = Math.round(size.height / 2 - ((tile.row + 1) * TILE - camera.y) * camera.scale);
      const y1 = Math.round(size.height / 2 - (tile.row * TILE - camera.y) * camera.scale);
      context.drawImage(level.canvas, x0, y0, x1 - x0, y1 - y0);
      ++this.drawn;
    }
    if (this.pixels > MAX_PIXELS) this.forget();
    return isComplete;
  }

  private *seen(camera: Camera, size: Size): Generator<Tile> {
    const [halfX, halfY] = [size.width / 2 / camera.scale, size.height / 2 / camera.scale];
    const [firstColumn, lastColumn] = [Math.floor((camera.x - halfX) / TILE), Math.floor((camera.x + halfX) / TILE)];
    const [firstRow, lastRow] = [Math.floor((camera.y - halfY) / TILE), Math.floor((camera.y + halfY) / TILE)];
    for (const tile of this.tiles.values()) {
      if (tile.row >= firstRow && tile.row <= lastRow && tile.column >= firstColumn && tile.column <= lastColumn) yield tile;
    }
  }

  // The tile at the wanted zoom; if there is no time to paint it, at another one.
  private best(tile: Tile, wanted: number, isLate: boolean): Level | undefined {
    const key = tileKey(tile.row, tile.column);
    let levels = this.levels.get(key);
    if (!levels) this.levels.set(key, (levels = []));
    let level = levels[wanted];
    if (!level && isLate) level = levels.find((other) => other !== undefined);
    if (!level && isLate) return undefined;
    if (!level) {
      level = levels[wanted] = newLevel(wanted);
      this.pixels += level.canvas.width ** 2;
    }
    if (level.stale && !isLate) this.paint(tile, level, Math.log2(TILE / level.canvas.width));
    level.usedIn = this.frame;
    return level;
  }

  private paint(tile: Tile, level: Level, zoom: number) {
    const { x0, y0, x1, y1 } = level.stale!;
    level.stale = undefined;
    const [left, right, low, high] = [x0 >> zoom, ((x1 - 1) >> zoom) + 1, y0 >> zoom, ((y1 - 1) >> zoom) + 1];
    const side = TILE >> zoom;
    const image = new ImageData(right - left, high - low);
    const words = new Uint32Array(image.data.buffer);
    let at = 0;
    // Rows go up in the tile, and down in the picture.
    for (let row = high - 1; row >= low; --row) {
      for (let column = left; column < right; ++column) words[at++] = this.colours[zoom === 0 ? tile.cells[row * TILE + column]! : strongest(tile.cells, row, column, zoom)]!;
    }
    level.context.putImageData(image, left, side - high);
  }

  private forget() {
    for (const [key, levels] of this.levels) {
      levels.forEach((level, i) => {
        if (!level || level.usedIn === this.frame) return;
        this.pixels -= level.canvas.width ** 2;
        delete levels[i];
      });
      if (levels.every((level) => level === undefined)) this.levels.delete(key);
    }
  }
}

function newLevel(zoom: number): Level {
  const canvas = document.createElement('canvas');
  canvas.width = canvas.height = TILE >> zoom;
  return { canvas, context: canvas.getContext('2d')!, stale: { x0: 0, y0: 0, x1: TILE, y1: TILE }, usedIn: 0 };
}

// For people who want to know what they change: the draft's cells are tinted.
export function coloursOf(unknown: number[], free: number[], occupied: number[], tint: number[], isTinted: boolean): Uint32Array {
  return Uint32Array.from({ length: 64 }, (_, cell) => {
    const shown = shownOf(cell);
    const base = shown === UNKNOWN ? unknown : shown === OCCUPIED ? occupied : free;
    const share = isTinted && editedOf(cell) !== publishedOf(cell) ? 0.4 : 0;
    const [r, g, b] = base.map((value, i) => Math.round(value + (tint[i]! - value) * share));
    return ((255 << 24) | (b! << 16) | (g! << 8) | r!) >>> 0;
  });
}
