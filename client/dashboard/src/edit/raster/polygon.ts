// SPDX-License-Identifier: Apache-2.0
import { ceilDiv, centreOf, firstFrom, lastUpTo, UNITS, type Units } from '../lattice';
import type { SpanList } from './spans';

export type Ring = readonly Units[];

// The sides of all rings, each from its lower end to its upper one.
function* sidesOf(rings: readonly Ring[]): Generator<[low: Units, high: Units]> {
  for (const ring of rings) {
    for (let i = 0; i < ring.length; ++i) {
      const [a, b] = [ring[i]!, ring[(i + 1) % ring.length]!];
      yield a.y > b.y ? [b, a] : [a, b];
    }
  }
}

// Cells whose centres lie on the side.
function addSide(list: SpanList, a: Units, b: Units) {
  const height = b.y - a.y;
  for (let row = firstFrom(a.y); row <= lastUpTo(b.y); ++row) {
    if (height === 0) {
      list.add(row, firstFrom(Math.min(a.x, b.x)), lastUpTo(Math.max(a.x, b.x)) + 1);
      continue;
    }
    const across = (centreOf(row) - a.y) * (b.x - a.x);
    if (across % height !== 0) continue;
    const x = a.x + across / height;
    if (firstFrom(x) === lastUpTo(x)) list.add(row, firstFrom(x), firstFrom(x) + 1);
  }
}

// Even-odd, row by row: a side that crosses the row toggles all cells whose centres are not left of it.
export function addPolygon(list: SpanList, rings: readonly Ring[]) {
  const toggles = new Map<number, number[]>();
  for (const [a, b] of sidesOf(rings)) {
    const height = b.y - a.y;
    for (let row = firstFrom(a.y); centreOf(row) < b.y; ++row) {
      const scaled = (a.x - UNITS / 2) * height + (centreOf(row) - a.y) * (b.x - a.x);
      const column = ceilDiv(scaled, UNITS * height);
      const columns = toggles.get(row);
      if (columns) columns.push(column);
      else toggles.set(row, [column]);
    }
  }
  for (const [row, columns] of toggles) {
    columns.sort((a, b) => a - b);
    for (let i = 0; i + 1 < columns.length; i += 2) list.add(row, columns[i]!, columns[i + 1]!);
  }
  for (const [a, b] of sidesOf(rings)) addSide(list, a, b);
}

const turn = (a: Units, b: Units, c: Units) => Math.sign((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x));

// Whether the insides of two sides have exactly one point in common.
const cross = (a: Units, b: Units, c: Units, d: Units) => turn(a, b, c) * turn(a, b, d) < 0 && turn(c, d, a) * turn(c, d, b) < 0;

// The numbers of two sides, counted from 0, that cross. Undefined: none do; touching is allowed.
export function crossingOf(ring: Ring): [number, number] | undefined {
  const n = ring.length;
  for (let i = 0; i < n; ++i) {
    for (let j = i + 2; j < n; ++j) {
      if (i === 0 && j === n - 1) continue;
      if (cross(ring[i]!, ring[i + 1]!, ring[j]!, ring[(j + 1) % n]!)) return [i, j];
    }
  }
  return undefined;
}
