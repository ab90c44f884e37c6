// SPDX-License-Identifier: Apache-2.0
import { expect, test } from 'vitest';
import { cornersOf, elementAt, graphOf, lengthOf, mayRemove, neighbour, placeOf, snapped, toGeoJson, wallsAt, withCornerMoved, withDoor, without, withMeasure, withThickness, withWall, type Element, type Graph } from './graph';
import { beginning, isChanged, stepped } from './steps';

const p = (x: number, y: number) => ({ x, y });
const feature = (properties: unknown, type: string, coordinates: unknown) => ({ type: 'Feature', properties, geometry: { type, coordinates } });
const room = feature({ kind: 'room', name: 'Hall' }, 'Polygon', [[[0, 0], [10, 0], [10, 10], [0, 0]]]);

// A square of walls with a door in the wall at the top.
const content = {
  type: 'FeatureCollection', frame: 'sheet', metres_per_unit: 0.05,
  features: [
    feature({ kind: 'corner' }, 'Point', [0, 0]),
    feature({ kind: 'wall', from: 0, to: 1, thickness: 4, confidence: 0.5 }, 'LineString', [[0, 0], [40, 0]]),
    feature({ kind: 'wall', thickness: 4 }, 'LineString', [[60, 0], [100, 0]]),
    feature({ kind: 'wall', thickness: 6 }, 'LineString', [[100, 0], [100, 100]]),
    feature({ kind: 'wall' }, 'LineString', [[100, 100], [0, 100]]),
    feature({ kind: 'wall', thickness: 4 }, 'LineString', [[0, 100], [0, 0]]),
    feature({ kind: 'door', confidence: 0.7 }, 'LineString', [[40, 0], [60, 0]]),
    room,
  ],
};
const graph = graphOf(content);

test('reads walls, doors and the scale, and keeps rooms as they are', () => {
  expect(graph.walls).toHaveLength(5);
  expect(graph.walls[0]).toEqual({ from: p(0, 0), to: p(40, 0), thickness: 4, confidence: 0.5 });
  expect(graph.walls[3]).toEqual({ from: p(100, 100), to: p(0, 100), thickness: 0, confidence: 1 });
  expect(graph.doors).toEqual([{ from: p(40, 0), to: p(60, 0), confidence: 0.7 }]);
  expect(graph.metresPerUnit).toBe(0.05);
  expect(graph.outlines).toEqual([room]);
  for (const nothing of [null, 3, {}, { features: [null, {}, feature(null, 'LineString', [[0, 0], [1, 1]]), feature({ kind: 'wall' }, 'LineString', [[0, 'x'], [1, 1]])] }]) {
    expect(graphOf(nothing)).toEqual({ walls: [], doors: [], outlines: [], metresPerUnit: undefined });
  }
});

test('sends what it has read', () => {
  expect(graphOf(JSON.parse(toGeoJson(graph)))).toEqual(graph);
  expect(JSON.parse(toGeoJson(graph))).toMatchObject({ frame: 'sheet', metres_per_unit: 0.05 });
  expect(JSON.parse(toGeoJson({ ...graph, metresPerUnit: undefined }))).not.toHaveProperty('metres_per_unit');
});

test('a new wall is as thick as most', () => {
  const next = withWall(graph, p(0, 50), p(100, 50));
  expect(next.walls.at(-1)).toEqual({ from: p(0, 50), to: p(100, 50), thickness: 4, confidence: 1 });
  expect(graph.walls).toHaveLength(5);
  expect(withWall(graph, p(1, 1), p(1, 1)).walls).toHaveLength(5);
  expect(withWall(graph, p(40, 0), p(0, 0)).walls, 'there is one').toHaveLength(5);
});

test('a moved corner takes walls and doors along', () => {
  const next = withCornerMoved(graph, p(40, 0), p(35, 1));
  expect(next.walls[0]!.to).toEqual(p(35, 1));
  expect(next.doors[0]!.from).toEqual(p(35, 1));
  expect(next.walls[4]).toEqual(graph.walls[4]);
  expect(withCornerMoved(graph, p(40, 0), p(0, 0)).walls, 'moved onto the next corner, a wall vanishes').toHaveLength(4);
  expect(withCornerMoved(graph, p(40, 0), p(60, 0)).doors).toEqual([]);
});

test('what is removed is gone, and without a corner two walls are one', () => {
  expect(without(graph, { kind: 'wall', index: 1 }).walls.map(lengthOf)).toEqual([40, 100, 100, 100]);
  expect(without(graph, { kind: 'door', index: 0 }).doors).toEqual([]);
  const joined = without(graph, { kind: 'corner', at: p(100, 100) });
  expect(joined.walls.at(-1)).toMatchObject({ from: p(100, 0), to: p(0, 100), thickness: 6 });
  expect(joined.walls).toHaveLength(4);
  expect(without(graph, { kind: 'corner', at: p(40, 0) }).walls, 'the wall that ends there').toHaveLength(4);
  const cross = withWall(graph, p(100, 100), p(50, 50));
  expect(wallsAt(cross, p(100, 100))).toHaveLength(3);
  expect(mayRemove(cross, { kind: 'corner', at: p(100, 100) })).toBe(false);
  expect(without(cross, { kind: 'corner', at: p(100, 100) })).toBe(cross);
});

test('thickness and scale are set', () => {
  expect(withThickness(graph, 0, 9).walls[0]).toMatchObject({ thickness: 9, confidence: 1 });
  expect(withMeasure(graph, p(0, 0), p(30, 40), 10).metresPerUnit).toBe(0.2);
  expect(withDoor(graph, p(1, 1), p(1, 1))).toBe(graph);
});

test('snaps to corners before walls', () => {
  expect(snapped(graph, p(41, 2), 5)).toEqual(p(40, 0));
  expect(snapped(graph, p(20, 3), 5)).toEqual(p(20, 0));
  expect(snapped(graph, p(20, 6), 5)).toEqual(p(20, 6));
});

test('finds what is meant', () => {
  expect(elementAt(graph, p(41, 2), 5)).toEqual({ kind: 'corner', at: p(40, 0) });
  expect(elementAt(graph, p(50, 2), 5)).toEqual({ kind: 'door', index: 0 });
  expect(elementAt(graph, p(99, 50), 5)).toEqual({ kind: 'wall', index: 2 });
  expect(elementAt(graph, p(50, 50), 5)).toBeUndefined();
});

test('all elements are reached one after the other', () => {
  const all = graph.walls.length + graph.doors.length + cornersOf(graph).length;
  const seen: Element[] = [];
  let at: Element | undefined;
  for (let i = 0; i < all; ++i) seen.push((at = neighbour(graph, at, 1)!));
  expect(new Set(seen.map((one) => JSON.stringify(one))).size).toBe(all);
  expect(neighbour(graph, at, 1)).toEqual(seen[0]);
  expect(neighbour(graph, seen[0], -1)).toEqual(at);
  expect(placeOf(graph, { kind: 'door', index: 0 })).toEqual(p(50, 0));
  expect(neighbour({ walls: [], doors: [], outlines: [], metresPerUnit: undefined }, undefined, 1)).toBeUndefined();
});

test('steps are undone and done again', () => {
  let steps = beginning(graph);
  const step = (to: Graph) => (steps = stepped(steps, { to }));
  step(withWall(graph, p(0, 50), p(100, 50)));
  const one = steps.now;
  step(without(one, { kind: 'wall', index: 0 }));
  expect(stepped(steps, { to: steps.now })).toBe(steps);
  steps = stepped(steps, 'undo');
  expect(steps.now).toBe(one);
  expect(stepped(steps, 'redo').now.walls).toHaveLength(5);
  steps = stepped(steps, 'undo');
  expect(isChanged(steps)).toBe(false);
  expect(stepped(steps, 'undo')).toBe(steps);
  step(withDoor(graph, p(0, 1), p(0, 2)));
  expect(stepped(steps, 'redo'), 'another way was taken').toBe(steps);
  expect(isChanged(steps)).toBe(true);
  expect(isChanged(stepped(steps, 'discard'))).toBe(false);
  const stored = graphOf(content);
  expect(stepped(steps, { saved: stored })).toEqual(beginning(stored));
});
