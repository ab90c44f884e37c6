// SPDX-License-Identifier: Apache-2.0
import { TILE, tileKey, tileOf, type Box } from '../lattice';

// Cells as triples (row, begin, end) in order, which neither overlap nor touch: cells of a row from begin to before end.
export type Spans = Int32Array;

export const NONE: Spans = new Int32Array(0);

// Takes spans in any order, also overlapping ones.
export class SpanList {
  private readonly triples: number[] = [];

  add(row: number, begin: number, end: number) {
    if (begin < end) this.triples.push(row, begin, end);
  }

  // Sorted by rows with a table of them, then within each.
  take(): Spans {
    const { triples } = this;
    if (triples.length === 0) return NONE;
    const rows = new Map<number, number[]>();
    for (let i = 0; i < triples.length; i += 3) {
      const row = triples[i]!;
      let list = rows.get(row);
      if (!list) rows.set(row, (list = []));
      list.push(i);
    }
    const all: number[] = [];
    for (const row of [...rows.keys()].sort((a, b) => a - b)) {
      const list = rows.get(row)!;
      if (list.length > 1) list.sort((a, b) => triples[a + 1]! - triples[b + 1]!);
      let begin = triples[list[0]! + 1]!;
      let end = triples[list[0]! + 2]!;
      for (let k = 1; k < list.length; ++k) {
        const next = triples[list[k]! + 1]!;
        if (next > end) {
          all.push(row, begin, end);
          begin = next;
        }
        end = Math.max(end, triples[list[k]! + 2]!);
      }
      all.push(row, begin, end);
    }
    return Int32Array.from(all);
  }
}

export function cellCount(spans: Spans): number {
  let count = 0;
  for (let i = 0; i < spans.length; i += 3) count += spans[i + 2]! - spans[i + 1]!;
  return count;
}

export function boxOf(spans: Spans): Box | undefined {
  if (spans.length === 0) return undefined;
  let [first, end] = [Infinity, -Infinity];
  for (let i = 0; i < spans.length; i += 3) {
    first = Math.min(first, spans[i + 1]!);
    end = Math.max(end, spans[i + 2]!);
  }
  const firstRow = spans[0]!;
  return { firstColumn: first, firstRow, width: end - first, height: spans[spans.length - 3]! + 1 - firstRow };
}

// The index of the first triple whose row is not below `row`.
export function firstOfRow(spans: Spans, row: number): number {
  let low = 0;
  let high = spans.length / 3;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (spans[3 * middle]! < row) low = middle + 1;
    else high = middle;
  }
  return 3 * low;
}

// The keys of the tiles that have cells of it.
export function tilesOf(spans: Spans): Set<number> {
  const keys = new Set<number>();
  for (let i = 0; i < spans.length; i += 3) {
    const row = tileOf(spans[i]!);
    const last = tileOf(spans[i + 2]! - 1);
    for (let column = tileOf(spans[i + 1]!); column <= last; ++column) keys.add(tileKey(row, column));
  }
  return keys;
}

// Calls visit(row, begin, end) for the parts inside columns [firstColumn, endColumn) of rows [firstRow, endRow).
export function visitWithin(spans: Spans, firstRow: number, endRow: number, firstColumn: number, endColumn: number,
                            visit: (row: number, begin: number, end: number) => void) {
  for (let i = firstOfRow(spans, firstRow); i < spans.length && spans[i]! < endRow; i += 3) {
    const begin = Math.max(spans[i + 1]!, firstColumn);
    const end = Math.min(spans[i + 2]!, endColumn);
    if (begin < end) visit(spans[i]!, begin, end);
  }
}

export function touches(spans: Spans, { firstRow, firstColumn, width, height }: Box): boolean {
  let isTouched = false;
  visitWithin(spans, firstRow, firstRow + height, firstColumn, firstColumn + width, () => (isTouched = true));
  return isTouched;
}

export const TILE_CELLS = TILE * TILE;
