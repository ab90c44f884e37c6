// SPDX-License-Identifier: Apache-2.0
// What is told to people of others' changes, of merges, of splits, and of candidates.
import { create } from '@bufbuild/protobuf';
import { expect, test } from 'vitest';
import { GraphLinkPointSchema } from '../gen/enfilade/v1/graph_pb';
import { SessionSchema, Session_State } from '../gen/enfilade/v1/session_pb';
import { deletionsOf, everything, fits, linedUp, MOST_CHANGES, portions, suspensionsOf } from './candidates';
import { differencesOf } from './differences';
import { planMerge, planSplit, type Leaving } from './rearranging';
import { linkPoint, mapName, titleOf } from './testing';

const session = (id: string, map: string, state = Session_State.MAPPED) => create(SessionSchema, { name: `sites/s/sessions/${id}`, map: mapName(map), state });
const joins = (...maps: string[]) => create(GraphLinkPointSchema, { linkPoint: 'sites/s/linkPoints/p', maps: maps.map(mapName) });

test('tells what another person has changed', () => {
  const base = linkPoint('door', { a: [1, 2, 0], b: [3, 4, 1] });
  const theirs = linkPoint('door', { a: [1.3, 2.4, 0], c: [0, 0, 0] }, { use: 'USE_SUSPENDED', state: 'STATE_BLOCKED' });
  expect(differencesOf(base, theirs, titleOf)).toEqual(['Anchor in a: moved by 50.0 cm, 0.00°', 'Anchor in c: added', 'Anchor in b: taken away', 'State: Open → Blocked', 'Suspended']);
  expect(differencesOf(base, undefined, titleOf)).toEqual(['Deleted']);
  expect(differencesOf(base, base, titleOf)).toEqual(['Something that this page does not show']);
});

test('the map that carries the world frame stays, and what goes with the other one is counted', () => {
  const plan = planMerge(mapName('b'), mapName('root'), mapName('root'), [joins('b', 'root'), joins('b', 'c'), joins('c', 'root')], [session('1', 'b'), session('2', 'root')], titleOf);
  expect([plan.stays, plan.goes, plan.refusal]).toEqual([mapName('root'), mapName('b'), undefined]);
  expect(plan.lines.slice(0, 4)).toEqual([
    '“b” becomes a part of “root”, and its name leads there.', '1 session moves into it; the map is drawn anew from all its sessions.', '1 link point between the two goes.', '1 link point to other maps stays.',
  ]);
});

test('sessions that are recorded or mapped hold up a merge and a split', () => {
  expect(planMerge(mapName('a'), mapName('b'), '', [], [session('1', 'b', Session_State.RECORDING)], titleOf).refusal).toMatch(/^1 session of “b” is still/);
  const own = [session('1', 'a', Session_State.FINISHED), session('2', 'a')];
  expect(planSplit(mapName('a'), own, new Map([[own[0]!.name, 'leaves']]), titleOf).refusal).toMatch(/^1 session that would leave is still/);
});

test('a split divides something', () => {
  const own = [session('1', 'a'), session('2', 'a')];
  const refusal = (...leaving: string[]) => planSplit(mapName('a'), own, new Map(leaving.map((name) => [name, 'leaves'])), titleOf).refusal;
  expect(refusal()).toBe('Choose at least one session that leaves.');
  expect(refusal(own[0]!.name, own[1]!.name)).toBe('One session must stay, or nothing is divided.');
  expect(refusal(own[0]!.name)).toBeUndefined();
  const cut = planSplit(mapName('a'), own, new Map<string, Leaving>([[own[0]!.name, 'leaves'], [own[1]!.name, 42n]]), titleOf);
  expect(cut.refusal).toBeUndefined();
  expect(cut.lines).toContain('The rest of 1 session does so as a session of its own.');
});

test('candidates are found by map, kind, pictures and words', () => {
  const point = linkPoint('c1', { hall: [0, 0, 0] }, { kind: 'KIND_LIFT', tag: 'freight', evidence: [{ map: mapName('hall'), image: { encoding: 'ENCODING_JPEG' } }] });
  const found = (wanted: object) => fits(point, { ...everything, ...wanted }, titleOf);
  expect([found({}), found({ map: mapName('hall') }), found({ map: mapName('yard') }), found({ kind: 2 }), found({ kind: 1 })]).toEqual([true, true, false, true, false]);
  expect([found({ pictures: 'with' }), found({ pictures: 'without' }), found({ text: 'FREIGHT hall' }), found({ text: 'stairs' })]).toEqual([true, false, true, false]);
});

test('doors along a corridor are put on the line that fits them best', () => {
  const doors = [[0, 0.1], [2, 1.9], [4, 4.1], [6, 5.9]].map(([x, y], i) => linkPoint(`d${i}`, { a: [x!, y!, 0.7] }));
  const { changes, farthest } = linedUp(doors)!;
  const places = changes.map(({ change }) => (change.value as typeof doors[0]).anchors[0]!.poseMapPlace!.pose!);
  expect(places).toHaveLength(4);
  const [first, last] = [places[0]!, places[3]!];
  for (const { x, y, yaw } of places) {
    expect((x - first.x) * (last.y - first.y) - (y - first.y) * (last.x - first.x)).toBeCloseTo(0, 9);
    expect(yaw).toBe(0.7);
  }
  expect(farthest).toBeGreaterThan(0.05);
  expect(farthest).toBeLessThan(0.1);
  expect(linedUp(doors.slice(0, 2))).toBeUndefined();
  expect(linedUp([...doors, linkPoint('far', { b: [0, 0, 0] })])).toBeUndefined();
});

test('many are changed in portions of one request', () => {
  const many = Array.from({ length: 120 }, (_, i) => linkPoint(`c${i}`, { a: [0, 0, 0] }));
  const parts = portions(deletionsOf(many));
  expect(parts.map((part) => part.length)).toEqual([MOST_CHANGES, 20]);
  expect(parts.flat().every(({ change, etag }) => change.case === 'deleted' && etag === '"5"')).toBe(true);
  expect(suspensionsOf([linkPoint('off', { a: [0, 0, 0] }, { use: 'USE_SUSPENDED' })])).toEqual([]);
});
