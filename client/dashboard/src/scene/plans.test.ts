// SPDX-License-Identifier: Apache-2.0
import { expect, test } from 'vitest';
import { boundsOfLines, linesOfPlan, mayShow } from './plans';

const feature = (properties: unknown, coordinates: unknown, type = 'LineString') => ({ type: 'Feature', properties, geometry: { type, coordinates } });
const collection = (...features: unknown[]) => ({ type: 'FeatureCollection', features });

test('reads walls and doors with what robots know of them', () => {
  const lines = linesOfPlan(collection(
    feature({ kind: 'wall', state: 'seen', stretch: 1.01, sigma_m: 0.02 }, [[0, 0], [4, 0], [4, 3]]),
    feature({ kind: 'wall', state: 'added' }, [[0, 3], [1, 3]]),
    feature({ kind: 'door', state: 'contradicted' }, [[1, 3], [2, 3]]),
  ));
  expect(lines).toEqual([
    { from: { x: 0, y: 0 }, to: { x: 4, y: 0 }, kind: 'wall', state: 'seen' },
    { from: { x: 4, y: 0 }, to: { x: 4, y: 3 }, kind: 'wall', state: 'seen' },
    { from: { x: 0, y: 3 }, to: { x: 1, y: 3 }, kind: 'wall', state: 'added' },
    { from: { x: 1, y: 3 }, to: { x: 2, y: 3 }, kind: 'door', state: 'contradicted' },
  ]);
});

test('takes a wall of an unknown state for one that nobody has seen', () => {
  expect(linesOfPlan(collection(feature({ kind: 'wall', state: 'new' }, [[0, 0], [1, 0]])))[0]?.state).toBe('unseen');
  expect(linesOfPlan(collection(feature({ kind: 'wall' }, [[0, 0], [1, 0]])))[0]?.state).toBe('unseen');
});

test('leaves out what is no line', () => {
  const wall = { kind: 'wall', state: 'seen' };
  for (const content of [null, 'text', {}, { features: 3 }, collection(null), collection(feature(wall, [0, 0], 'Point')), collection(feature({ kind: 'corner' }, [[0, 0], [1, 0]])),
    collection(feature(null, [[0, 0], [1, 0]])), collection(feature(wall, [[0, 0]])), collection(feature(wall, [[0, 'x'], [1, 0]])), collection(feature(wall, null))]) {
    expect(linesOfPlan(content)).toEqual([]);
  }
});

test('spans all lines', () => {
  expect(boundsOfLines(linesOfPlan(collection(feature({ kind: 'wall' }, [[1, 5], [-2, 0], [0, 7]]))))).toEqual({ minX: -2, minY: 0, maxX: 1, maxY: 7 });
  expect(boundsOfLines([])).toBeUndefined();
});

test('passes over lines beside the window', () => {
  const window = { minX: 0, minY: 0, maxX: 10, maxY: 10 };
  const line = (x0: number, y0: number, x1: number, y1: number) => mayShow({ from: { x: x0, y: y0 }, to: { x: x1, y: y1 }, kind: 'wall', state: 'seen' }, window);
  expect([line(-5, 5, 15, 5), line(2, 2, 3, 3), line(9, 12, 9, 9)]).toEqual([true, true, true]);
  expect([line(-5, 5, -1, 5), line(11, 0, 12, 10), line(0, -3, 10, -1), line(0, 11, 10, 30)]).toEqual([false, false, false, false]);
});
