// SPDX-License-Identifier: Apache-2.0
import { expect, test } from 'vitest';
import { LinkPoint_Kind as Kind, LinkPoint_State as State, LinkPoint_Use as Use } from '../gen/enfilade/v1/link_point_pb';
import { anchorsOf, changesOf, editOf, isIdle, isPinned, laidOn, movedTo, pinToggled, spreadTo, toggled, wantedOf, withoutAnchor } from './draft';
import { nothingDrafted, stepped, type Drafted } from './drafted';
import { byHand, covarianceOf } from './spread';
import { linkPoint, linkPointName, mapName, scanner } from './testing';

const door = linkPoint('door', { a: [1, 2, 0], b: [3, 4, 1] });
const pose = { x: 5, y: 6, yaw: 0.5 };
const cases = (state: Drafted) => changesOf(state.draft).map(({ change }) => change.case);

test('what a hand has moved is known as exactly as a hand, and what has not been moved stays as it is', () => {
  const wanted = wantedOf(movedTo(editOf(door), mapName('b'), pose));
  expect(wanted.anchors.map(({ map }) => map)).toEqual([mapName('a'), mapName('b')]);
  expect(wanted.anchors[0]).toEqual(door.anchors[0]);
  expect(wanted.anchors[1]?.poseMapPlace?.pose).toMatchObject(pose);
  expect(wanted.anchors[1]?.poseMapPlace?.covariance).toEqual(covarianceOf(byHand));
});

test('a spread that was entered outlives further moves', () => {
  const measured = covarianceOf({ major: 0.02, minor: 0.02, angle: 0, yaw: 0.01 });
  const edit = movedTo(spreadTo(editOf(door), mapName('b'), measured), mapName('b'), pose);
  expect(anchorsOf(edit).get(mapName('b'))).toEqual({ pose, covariance: measured });
});

test('a change is an update of the whole link point, with the etag of what the person saw', () => {
  const [change] = changesOf(new Map([[door.name, movedTo(editOf(door), mapName('a'), pose)]]));
  expect(change?.change.case).toBe('updated');
  expect(change?.change.value).toMatchObject({ name: door.name, etag: '"5"', kind: Kind.DOOR });
  expect(change?.updateMask?.paths).toEqual(['anchors']);
});

test('the first change of a link point has the etag', () => {
  const changes = changesOf(new Map([[door.name, toggled(editOf(door))]]));
  expect(changes.map(({ change, etag }) => [change.case, etag])).toEqual([['suspended', '"5"']]);
  const moved = movedTo(editOf(door), mapName('a'), pose);
  expect(changesOf(new Map([[door.name, toggled(moved)]])).map(({ change, etag }) => [change.case, etag])).toEqual([['updated', ''], ['suspended', '']]);
  expect(changesOf(new Map([[door.name, { ...moved, isDeleted: true }]])).map(({ change, etag }) => [change.case, etag])).toEqual([['deleted', '"5"']]);
});

test('a state that is set by hand has no end', () => {
  const closed = linkPoint('door', { a: [1, 2, 0] }, { state: 'STATE_CLOSED', stateValidUntil: '2030-01-01T00:00:00Z' });
  expect(wantedOf({ ...editOf(closed), state: State.OPEN }).stateValidUntil).toBeUndefined();
  expect(wantedOf({ ...editOf(closed), kind: Kind.LIFT }).stateValidUntil).toEqual(closed.stateValidUntil);
  const [change] = changesOf(new Map([[closed.name, { ...editOf(closed), state: State.OPEN }]]));
  expect(change?.updateMask?.paths).toEqual(['state', 'state_valid_until']);
});

test('what leads back to what is there is no change', () => {
  const there = { pose: { x: 1, y: 2, yaw: 0 }, covariance: scanner };
  expect(isIdle({ ...editOf(door), anchors: { [mapName('a')]: there } })).toBe(true);
  expect(isIdle(toggled(toggled(editOf(door))))).toBe(true);
  expect(isIdle(toggled(editOf(door)))).toBe(false);
  expect(isIdle({ ...editOf(door), kind: Kind.DOOR })).toBe(true);
  expect(isIdle({ ...editOf(door), kind: Kind.LIFT })).toBe(false);
});

test('an anchor is added, and taken away again as if it had never been', () => {
  const candidate = linkPoint('seen', { a: [1, 2, 0] });
  const promoted = movedTo(editOf(candidate), mapName('b'), pose);
  expect([...anchorsOf(promoted).keys()]).toEqual([mapName('a'), mapName('b')]);
  expect(isIdle(withoutAnchor(promoted, mapName('b')))).toBe(true);
  expect([...anchorsOf(withoutAnchor(editOf(door), mapName('a'))).keys()]).toEqual([mapName('b')]);
  const entered = linkPoint('door', { a: [1, 2, 0], b: [3, 4, 1] }, { directionMap: mapName('a') });
  const [change] = changesOf(new Map([[door.name, withoutAnchor(editOf(entered), mapName('a'))]]));
  expect(change?.updateMask?.paths).toEqual(['anchors', 'direction_map']);
  expect(change?.change.value).toMatchObject({ directionMap: '' });
});

test('undo and redo go step by step; a drag is one step', () => {
  let state = nothingDrafted;
  for (const x of [1.1, 1.2, 1.3]) state = stepped(state, { edits: [movedTo(editOf(door), mapName('a'), { ...pose, x })], tag: 'middle 1' });
  state = stepped(state, { edits: [toggled(state.draft.get(door.name)!)] });
  expect(cases(state)).toEqual(['updated', 'suspended']);
  state = stepped(state, 'undo');
  expect(cases(state)).toEqual(['updated']);
  expect(anchorsOf(state.draft.get(door.name)!).get(mapName('a'))?.pose.x).toBe(1.3);
  state = stepped(state, 'undo');
  expect(cases(state)).toEqual([]);
  expect(stepped(state, 'undo')).toBe(state);
  expect(cases(stepped(stepped(state, 'redo'), 'redo'))).toEqual(['updated', 'suspended']);
});

test('what another person has changed stays below what is changed here', () => {
  const mine = movedTo(editOf(door), mapName('b'), pose);
  const theirs = linkPoint('door', { a: [9, 9, 0], b: [3, 4, 1] }, { etag: '"6"', use: 'USE_SUSPENDED' });
  const state = stepped(stepped(nothingDrafted, { edits: [mine] }), { theirs });
  const wanted = wantedOf(state.draft.get(door.name)!);
  expect(wanted.etag).toBe('"6"');
  expect(wanted.anchors[0]).toEqual(theirs.anchors[0]);
  expect(wanted.anchors[1]?.poseMapPlace?.pose).toMatchObject(pose);
  expect(laidOn(toggled(editOf(door)), theirs).use).toBeUndefined();
  expect(wanted.use).toBe(Use.SUSPENDED);
});

test('dropping one link point leaves the others', () => {
  const lift = linkPoint('lift', { a: [0, 0, 0], c: [0, 0, 0] });
  let state = stepped(nothingDrafted, { edits: [toggled(editOf(door)), toggled(editOf(lift))] });
  state = stepped(state, { drop: door.name });
  expect([...state.draft.keys()]).toEqual([linkPointName('lift')]);
});

test('what is placed by hand is pinned, unless the person says otherwise', () => {
  const paths = (edit: Parameters<typeof isPinned>[0]) => changesOf(new Map([[edit.base.name, edit]])).map(({ updateMask }) => updateMask?.paths);
  const moved = movedTo(editOf(door), mapName('a'), pose);
  expect([isPinned(editOf(door)), isPinned(moved), isPinned(pinToggled(moved))]).toEqual([false, true, false]);
  expect(paths(moved)).toEqual([['anchors']]);
  expect(paths(pinToggled(moved))).toEqual([['anchors', 'pinned']]);
  expect(wantedOf(pinToggled(moved)).pinned).toBe(false);
});

test('a pin alone is a change, and taken back twice is none', () => {
  const pinned = linkPoint('door', { a: [1, 2, 0] }, { pinned: true });
  const [change] = changesOf(new Map([[door.name, pinToggled(editOf(pinned))]]));
  expect(change?.updateMask?.paths).toEqual(['pinned']);
  expect(change?.change.value).toMatchObject({ pinned: false });
  expect(isIdle(pinToggled(pinToggled(editOf(pinned))))).toBe(true);
  expect(isIdle(laidOn(pinToggled(editOf(pinned)), linkPoint('door', { a: [1, 2, 0] })))).toBe(true);
});
