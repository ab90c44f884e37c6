// SPDX-License-Identifier: Apache-2.0
// Shapes against their definition, cell by cell, in integers without bounds.
import { expect, test } from 'vitest';
import { centreOf, UNITS, type Units } from '../lattice';
import { random } from '../random.testing';
import { addBrush } from './brush';
import { addLine } from './line';
import { addPatch, runsOf } from './patch';
import { addPolygon, crossingOf } from './polygon';
import { boxOf, cellCount, SpanList, tilesOf, type Spans } from './spans';

const made = (fill: (list: SpanList) => void) => {
  const list = new SpanList();
  fill(list);
  return list.take();
};

function cellsOf(spans: Spans): Set<string> {
  const cells = new Set<string>();
  for (let i = 0; i < spans.length; i += 3) for (let column = spans[i + 1]!; column < spans[i + 2]!; ++column) cells.add(`${spans[i]},${column}`);
  return cells;
}

// All cells of a window whose centres `holds`.
function expected(low: Units, high: Units, holds: (x: bigint, y: bigint) => boolean): Set<string> {
  const cells = new Set<string>();
  for (let row = Math.floor(low.y / UNITS) - 2; row <= Math.floor(high.y / UNITS) + 2; ++row) {
    for (let column = Math.floor(low.x / UNITS) - 2; column <= Math.floor(high.x / UNITS) + 2; ++column) {
      if (holds(BigInt(centreOf(column)), BigInt(centreOf(row)))) cells.add(`${row},${column}`);
    }
  }
  return cells;
}

const window = (points: readonly Units[], margin = 0): [Units, Units] => [
  { x: Math.min(...points.map(({ x }) => x)) - margin, y: Math.min(...points.map(({ y }) => y)) - margin },
  { x: Math.max(...points.map(({ x }) => x)) + margin, y: Math.max(...points.map(({ y }) => y)) + margin },
];

// distance(p, ab)^2 <= r^2, as a fraction: cross^2 / length^2 where p lies beside the segment.
function isNear(a: Units, b: Units, radius: number, x: bigint, y: bigint): boolean {
  const [ax, ay, bx, by, r] = [a.x, a.y, b.x, b.y, radius].map(BigInt) as [bigint, bigint, bigint, bigint, bigint];
  const [dx, dy, px, py] = [bx - ax, by - ay, x - ax, y - ay];
  const [along, length2] = [px * dx + py * dy, dx * dx + dy * dy];
  if (along <= 0n) return px * px + py * py <= r * r;
  if (along >= length2) return (x - bx) ** 2n + (y - by) ** 2n <= r * r;
  return (px * dy - py * dx) ** 2n <= r * r * length2;
}

// The even-odd rule by a ray to the left, and centres on a side.
function isInside(rings: readonly (readonly Units[])[], x: bigint, y: bigint): boolean {
  let inside = false;
  for (const ring of rings) {
    for (let i = 0; i < ring.length; ++i) {
      let [a, b] = [ring[i]!, ring[(i + 1) % ring.length]!];
      if (a.y > b.y) [a, b] = [b, a];
      const [ax, ay, bx, by] = [a.x, a.y, b.x, b.y].map(BigInt) as [bigint, bigint, bigint, bigint];
      const side = (bx - ax) * (y - ay) - (by - ay) * (x - ax);
      const between = (low: bigint, high: bigint, value: bigint) => (low < high ? low <= value && value <= high : high <= value && value <= low);
      if (side === 0n && between(ax, bx, x) && between(ay, by, y)) return true;
      if (ay <= y && y < by && side < 0n) inside = !inside;
    }
  }
  return inside;
}

test('a brush has the cells whose centres are within its radius of its path', () => {
  const next = random(1);
  for (let round = 0; round < 300; ++round) {
    const scale = [600, 3000, 9000][round % 3]!;
    const point = () => ({ x: next(-scale, scale), y: next(-scale, scale) });
    const points = Array.from({ length: next(1, 4) }, point);
    if (round % 7 === 0) points.push({ ...points[0]!, x: points[0]!.x + 256 }); // along a row
    if (round % 11 === 0) points.push({ ...points.at(-1)! }); // nowhere
    const radius = [0, 128, 129, 256, next(0, 2000)][round % 5]!;
    const segments = points.length === 1 ? [[points[0]!, points[0]!] as const] : points.slice(1).map((to, i) => [points[i]!, to] as const);
    const spans = made((list) => addBrush(list, points, radius));
    expect(cellsOf(spans), JSON.stringify({ points, radius })).toEqual(
      expected(...window(points, radius), (x, y) => segments.some(([a, b]) => isNear(a, b, radius, x, y))));
  }
});

test('a brush is exact at the ends of the coordinates, where floats are not', () => {
  const a = { x: 2 ** 29 - 5, y: -(2 ** 29) + 77 };
  for (const [dx, dy] of [[-(2 ** 22), 2 ** 22 - 1], [-(2 ** 22) + 3, 12_345], [-511, 2 ** 22]] as const) {
    const b = { x: a.x + dx, y: a.y + dy };
    const spans = made((list) => addBrush(list, [a, b], 65_536));
    expect(spans.length).toBeGreaterThan(0);
    for (let i = 0; i < spans.length; i += 3 * 97) {
      const [row, begin, end] = [spans[i]!, spans[i + 1]!, spans[i + 2]!];
      const holds = (column: number) => isNear(a, b, 65_536, BigInt(centreOf(column)), BigInt(centreOf(row)));
      expect([holds(begin - 1), holds(begin), holds(end - 1), holds(end)]).toEqual([false, true, true, false]);
    }
  }
});

test('a polygon has the cells whose centres are inside by the even-odd rule, or on a side', () => {
  const next = random(2);
  for (let round = 0; round < 300; ++round) {
    // Coordinates on multiples of half a cell meet centres often.
    const step = [1, 64, 128][round % 3]!;
    const point = () => ({ x: step * next(-3000 / step, 3000 / step), y: step * next(-3000 / step, 3000 / step) });
    const rings = Array.from({ length: next(1, 2) }, () => Array.from({ length: next(3, 7) }, point));
    expect(cellsOf(made((list) => addPolygon(list, rings))), JSON.stringify(rings)).toEqual(expected(...window(rings.flat()), (x, y) => isInside(rings, x, y)));
  }
});

test('a line joins its cells, whichever way it is drawn', () => {
  const next = random(3);
  for (let round = 0; round < 300; ++round) {
    const [a, b] = [0, 1].map(() => ({ x: next(-9000, 9000), y: next(-9000, 9000) })) as [Units, Units];
    const there = cellsOf(made((list) => addLine(list, [a, b])));
    expect(cellsOf(made((list) => addLine(list, [b, a])))).toEqual(there);
    const [columns, rows] = [Math.abs(Math.floor(a.x / UNITS) - Math.floor(b.x / UNITS)), Math.abs(Math.floor(a.y / UNITS) - Math.floor(b.y / UNITS))];
    expect(there.size).toBe(Math.max(columns, rows) + 1);
  }
  // A tie goes to the cell with the greater row.
  expect([...cellsOf(made((list) => addLine(list, [{ x: 0, y: 0 }, { x: 512, y: 256 }])))]).toEqual(['0,0', '1,1', '1,2']);
  expect([...cellsOf(made((list) => addLine(list, [{ x: -1, y: -1 }])))]).toEqual(['-1,-1']);
});

test('a patch has the cells of its runs, and gives them back', () => {
  const next = random(4);
  for (let round = 0; round < 100; ++round) {
    const box = { firstColumn: next(-300, 300), firstRow: next(-300, 300), width: next(1, 40), height: next(1, 40) };
    const taken = Array.from({ length: box.width * box.height }, () => next(0, 2) === 0);
    const runs: number[] = [];
    taken.forEach((takes, i) => {
      if (takes === (i > 0 && taken[i - 1]!)) runs.length === 0 ? runs.push(1) : ++runs[runs.length - 1]!;
      else i === 0 ? runs.push(0, 1) : runs.push(1);
    });
    const spans = made((list) => addPatch(list, box, runs));
    const cells = new Set(taken.flatMap((takes, i) => (takes ? [`${box.firstRow + Math.floor(i / box.width)},${box.firstColumn + (i % box.width)}`] : [])));
    expect(cellsOf(spans)).toEqual(cells);
    expect(cellCount(spans)).toBe(cells.size);
    expect(cellsOf(made((list) => addPatch(list, box, runsOf(spans, box))))).toEqual(cells);
  }
});

test('spans are in order, apart from each other, and know their box and tiles', () => {
  const spans = made((list) => {
    for (const [row, begin, end] of [[5, 10, 20], [5, 20, 30], [-1, -3, 2], [5, 12, 14], [5, 300, 301], [7, 4, 4]] as const) list.add(row, begin, end);
  });
  expect([...spans]).toEqual([-1, -3, 2, 5, 10, 30, 5, 300, 301]);
  expect(boxOf(spans)).toEqual({ firstColumn: -3, firstRow: -1, width: 304, height: 7 });
  expect(tilesOf(spans).size).toBe(4);
});

test('a ring that crosses itself is found', () => {
  const ring = (...points: [number, number][]) => points.map(([x, y]) => ({ x, y }));
  expect(crossingOf(ring([0, 0], [10, 0], [10, 10], [0, 10]))).toBeUndefined();
  expect(crossingOf(ring([0, 0], [10, 10], [10, 0], [0, 10]))).toEqual([0, 2]);
  expect(crossingOf(ring([0, 0], [10, 0], [10, 5], [5, 0], [0, 5]))).toBeUndefined(); // touches
});
