// SPDX-License-Identifier: Apache-2.0
import { expect, test } from 'vitest';
import { MAX_POINTS, MAX_SIDE } from './lattice';
import { brushEdits, lineEdits, type Style } from './shapes';

const style: Style = { value: 2, onlyWhere: [], invisible: false, author: 'me' };
const pointsOf = (edits: ReturnType<typeof brushEdits>) => edits.map(({ shape }) => (shape.value as { points: { x: number; y: number }[] }).points.map(({ x, y }) => ({ x, y })));

test('a path that is too long for one edit becomes several, which meet', () => {
  const path = Array.from({ length: 25_000 }, (_, i) => ({ x: 300 * i, y: 0 }));
  const parts = pointsOf(brushEdits(style, path, 128));
  expect(parts.length).toBe(3);
  for (const [i, part] of parts.entries()) {
    expect(part.length).toBeLessThanOrEqual(MAX_POINTS);
    if (i > 0) expect(part[0]).toEqual(parts[i - 1]!.at(-1));
  }
  expect(parts.flat().filter((point, i, all) => point.x !== all[i - 1]?.x)).toEqual(path);
});

test('the largest brush goes over no more cells than the server allows', () => {
  const path = Array.from({ length: 1000 }, (_, i) => ({ x: 2000 * i, y: 0 }));
  for (const part of pointsOf(brushEdits(style, path, 65_536))) expect((part.length - 1) * 512 * 512).toBeLessThan(64e6);
});

test('a segment that is too long gets points in between', () => {
  const [part] = pointsOf(lineEdits(style, [{ x: 0, y: 0 }, { x: 2.5 * MAX_SIDE, y: 100 }]));
  expect(part).toHaveLength(4);
  part!.slice(1).forEach(({ x }, i) => expect(x - part![i]!.x).toBeLessThanOrEqual(MAX_SIDE));
  expect(pointsOf(lineEdits(style, [{ x: 5, y: 6 }]))).toEqual([[{ x: 5, y: 6 }]]);
});
