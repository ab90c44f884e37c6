// SPDX-License-Identifier: Apache-2.0
import { centreOf, firstFrom, lastUpTo, UNITS, type Units } from '../lattice';
import type { SpanList } from './spans';

// floor(sqrt(a b)): the product may exceed 2^53.
function rootOfProduct(a: number, b: number): number {
  const product = BigInt(a) * BigInt(b);
  let root = BigInt(Math.floor(Math.sqrt(a) * Math.sqrt(b)));
  while (root * root > product) --root;
  while ((root + 1n) * (root + 1n) <= product) ++root;
  return Number(root);
}

// Whether a point is within a distance of a segment. All products stay below 2^53.
function capsule(a: Units, b: Units, radius: number): (x: number, y: number) => boolean {
  const dx = b.x - a.x;
  const dy = b.y - a.y;
  const radius2 = radius * radius;
  const length2 = dx * dx + dy * dy;
  const maxCross = rootOfProduct(radius2, length2);
  return (x, y) => {
    const px = x - a.x;
    const py = y - a.y;
    const along = px * dx + py * dy;
    if (along <= 0) return px * px + py * py <= radius2;
    if (along >= length2) return (x - b.x) ** 2 + (y - b.y) ** 2 <= radius2;
    return Math.abs(px * dy - py * dx) <= maxCross;
  };
}

// The first cell of [low, high] that is inside, where all from some cell to `high` are; and the other way round.
function firstInside(low: number, high: number, isInside: (cell: number) => boolean): number {
  while (low < high) {
    const middle = Math.floor((low + high) / 2);
    if (isInside(middle)) high = middle;
    else low = middle + 1;
  }
  return high;
}
function lastInside(low: number, high: number, isInside: (cell: number) => boolean): number {
  while (low < high) {
    const middle = Math.ceil((low + high) / 2);
    if (isInside(middle)) low = middle;
    else high = middle - 1;
  }
  return low;
}

// Where the segment is nearest to a row: if any of the row is inside, this is.
function nearestX(a: Units, b: Units, y: number): number {
  if (a.y === b.y) return (a.x + b.x) / 2;
  return a.x + Math.min(1, Math.max(0, (y - a.y) / (b.y - a.y))) * (b.x - a.x);
}

// The cells whose centres are within `radius` of the segment. It is convex, so it meets a row in one span.
export function addSegment(list: SpanList, a: Units, b: Units, radius: number) {
  const contains = capsule(a, b, radius);
  const left = firstFrom(Math.min(a.x, b.x) - radius);
  const right = lastUpTo(Math.max(a.x, b.x) + radius);
  const lastRow = lastUpTo(Math.max(a.y, b.y) + radius);
  for (let row = firstFrom(Math.min(a.y, b.y) - radius); row <= lastRow; ++row) {
    const y = centreOf(row);
    const isInside = (cell: number) => contains(centreOf(cell), y);
    const middle = Math.floor(nearestX(a, b, y) / UNITS);
    const inside = [middle, middle - 1, middle + 1].find(isInside);
    if (inside === undefined) continue;
    list.add(row, firstInside(Math.min(left, inside), inside, isInside), lastInside(inside, Math.max(right, inside), isInside) + 1);
  }
}

export function addBrush(list: SpanList, points: readonly Units[], radius: number) {
  if (points.length === 1) addSegment(list, points[0]!, points[0]!, radius);
  for (let i = 1; i < points.length; ++i) addSegment(list, points[i - 1]!, points[i]!, radius);
}
