// SPDX-License-Identifier: Apache-2.0
import { create } from '@bufbuild/protobuf';
import { expect, test } from 'vitest';
import { PriorMapSchema } from '../../gen/enfilade/v1/prior_map_pb';
import { movedBy, placedPlan } from './placed';

const line = (x0: number, y0: number, x1: number, y1: number) => ({ from: { x: x0, y: y0 }, to: { x: x1, y: y1 }, thickness: 0, confidence: 1 });
const graph = { walls: [line(0, 0, 10, 0), line(10, 0, 10, 20)], doors: [line(2, 0, 4, 0)], outlines: [], metresPerUnit: undefined };
const plan = create(PriorMapSchema, { name: 'sites/s/priorMaps/p', level: 2, alignment: { affineWorldSheet: [0.1, 0.02, 5, 0, -0.1, 7] } });

test('places walls and doors as the alignment says', () => {
  const placed = placedPlan(plan, graph);
  expect(placed.lines[1]).toEqual({ from: { x: 6, y: 7 }, to: { x: 6.4, y: 5 }, kind: 'wall', state: 'placed' });
  expect(placed.lines[2]!.kind).toBe('door');
  expect(placed.bounds).toEqual({ minX: 5, minY: 5, maxX: 6.4, maxY: 7 });
  expect(placedPlan(create(PriorMapSchema, { name: 'p' }), graph).lines).toEqual([]);
});

test('tells how far walls were moved', () => {
  const placed = placedPlan(plan, graph);
  const corrected = { ...placed, lines: placed.lines.map((one, i) => (i === 1 ? { ...one, to: { x: one.to.x + 0.3, y: one.to.y - 0.4 } } : one)) };
  expect(movedBy(placed, corrected)!.median).toBe(0);
  expect(movedBy(placed, corrected)!.most).toBeCloseTo(0.5, 12);
  expect(movedBy(placed, { ...corrected, lines: corrected.lines.slice(1) })).toBeUndefined();
  const added = { ...corrected.lines[0]!, state: 'added' as const };
  expect(movedBy(placed, { ...corrected, lines: [...corrected.lines.slice(0, 2), added, ...corrected.lines.slice(2)] })).toEqual(movedBy(placed, corrected));
});
