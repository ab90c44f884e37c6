// SPDX-License-Identifier: Apache-2.0
import { expect, test } from 'vitest';
import type { Point } from '../../../scene/camera';
import type { Graph } from './graph';
import { beginningOf, edited, meant, type Act, type Editing } from './useEditing';

const p = (x: number, y: number) => ({ x, y });
const wall = (from: Point, to: Point) => ({ from, to, thickness: 2, confidence: 1 });
const graph: Graph = { walls: [wall(p(0, 0), p(100, 0)), wall(p(100, 0), p(100, 100))], doors: [], outlines: [], metresPerUnit: undefined };

const after = (...acts: Act[]) => acts.reduce<Editing>(edited, beginningOf(graph));
const click = (x: number, y: number, reach = 5): Act => ({ kind: 'click', at: p(x, y), reach });
const tool = (name: Editing['tool']): Act => ({ kind: 'tool', tool: name });

test('walls are drawn one after the other, from where the last one ended, until that is cancelled', () => {
  const drawn = after(tool('wall'), click(2, 1), click(50, 60), click(98, 99));
  expect(drawn.steps.now.walls.slice(2)).toEqual([wall(p(0, 0), p(50, 60)), wall(p(50, 60), p(100, 100))]);
  expect(drawn.first).toEqual(p(100, 100));
  const ended = edited(drawn, { kind: 'cancel' });
  expect(ended.first).toBeUndefined();
  expect(ended.steps).toBe(drawn.steps);
  expect(after(tool('wall'), click(2, 1), click(1, 2)).first, 'the same corner twice').toBeUndefined();
});

test('a door has two jambs, a measure two points', () => {
  const door = after(tool('door'), click(40, 2), click(60, 1));
  expect(door.steps.now.doors).toEqual([{ from: p(40, 0), to: p(60, 0), confidence: 1 }]);
  expect(door.first).toBeUndefined();
  const measure = after(tool('measure'), click(0, 0), click(50, 50));
  expect(measure.measured).toEqual({ from: p(0, 0), to: p(50, 50) });
  expect(measure.steps.done).toEqual([]);
  expect(edited(measure, tool('select')).measured).toBeUndefined();
});

test('a corner is dragged, or taken along by a second click, and does not stick to its own walls', () => {
  const dragged = after({ kind: 'grab', corner: p(100, 0) }, { kind: 'drop', at: p(96, 3), reach: 5 });
  expect(dragged.steps.now.walls[0]!.to).toEqual(p(96, 3));
  expect(dragged.selected).toEqual({ kind: 'corner', at: p(96, 3) });
  const taken = after(click(99, 1), click(99, 1));
  expect(taken.grabbed).toEqual(p(100, 0));
  expect(meant(taken, p(1, 0), 5), 'the far end of its wall is nothing to stick to').toEqual(p(1, 0));
  expect(edited(taken, click(120, 40)).steps.now.walls[1]!.from).toEqual(p(120, 40));
  expect(edited(taken, { kind: 'cancel' })).toMatchObject({ grabbed: undefined, steps: taken.steps });
  expect(after({ kind: 'grab', corner: p(100, 0) }, { kind: 'drop', at: p(100, 0), reach: 0 }).steps.done, 'put back').toEqual([]);
});

test('what is removed is selected no more, and a step back takes it back', () => {
  const removed = after(click(50, 1), { kind: 'remove' });
  expect(removed.steps.now.walls).toHaveLength(1);
  expect(removed.selected).toBeUndefined();
  expect(edited(removed, { kind: 'step', step: 'undo' }).steps.now).toBe(graph);
  expect(after({ kind: 'remove' }).steps.done, 'nothing is selected').toEqual([]);
});

test('the next element is selected, and the cross goes there', () => {
  const next = after(tool('wall'), { kind: 'next', step: 1 });
  expect(next).toMatchObject({ tool: 'select', selected: { kind: 'wall', index: 0 }, at: p(50, 0) });
});
