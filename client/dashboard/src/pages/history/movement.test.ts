// SPDX-License-Identifier: Apache-2.0
import { expect, test } from 'vitest';
import { stretchFor } from '../../scene/moves';
import type { Thumbnail } from '../../scene/tiles/manifest';
import { differenceOf } from './movement';

const picture = { pose: { x: 0, y: 0, yaw: 0 }, width: 40, height: 20, resolution: 0.5 } as Thumbnail;
const at = (x: number, y: number, yaw = 0) => ({ x, y, yaw });

test('tells how far the middle of a map has moved, and how far it has turned', () => {
  const { moved } = differenceOf(new Map([['m', at(0, 0)]]), new Map([['m', at(0, 0, Math.PI / 2)]]), new Map([['m', picture]]));
  // From (10, 5) to (-5, 10).
  expect(moved).toHaveLength(1);
  expect(moved[0]!.distance).toBeCloseTo(Math.hypot(15, 5));
  expect(moved[0]!.turn).toBeCloseTo(Math.PI / 2);
});

test('turns the shorter way around, and takes the frame of a map without a picture', () => {
  const { moved } = differenceOf(new Map([['m', at(1, 1, 3.1)]]), new Map([['m', at(4, 5, -3.1)]]), new Map());
  expect(moved[0]!.distance).toBeCloseTo(5);
  expect(moved[0]!.turn).toBeCloseTo(2 * Math.PI - 6.2);
});

test('lists what moved the farthest first, and apart what is new, gone, or has stayed', () => {
  const before = new Map([['near', at(0, 0)], ['far', at(0, 0)], ['still', at(1, 2)], ['gone', at(0, 0)]]);
  const after = new Map([['near', at(0.1, 0)], ['far', at(0, 3)], ['still', at(1, 2.0001)], ['new', at(0, 0)]]);
  const found = differenceOf(before, after, new Map());
  expect(found.moved.map(({ map }) => map)).toEqual(['far', 'near']);
  expect(found).toMatchObject({ still: 1, appeared: ['new'], gone: ['gone'] });
});

test('draws short ways longer by a power of ten, and long ones as they are', () => {
  const campus = { minX: 0, minY: 0, maxX: 30, maxY: 40 };
  expect(stretchFor(3, campus)).toBe(1);
  expect(stretchFor(0.3, campus)).toBe(10);
  expect(stretchFor(0.002, campus)).toBe(1000);
  expect(stretchFor(0, campus)).toBe(1);
});
