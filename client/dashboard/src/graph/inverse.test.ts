// SPDX-License-Identifier: Apache-2.0
import { create } from '@bufbuild/protobuf';
import { timestampFromMs } from '@bufbuild/protobuf/wkt';
import { expect, test } from 'vitest';
import { LinkPoint_Kind as Kind, LinkPoint_State as State, type LinkPoint } from '../gen/enfilade/v1/link_point_pb';
import { AuditEntrySchema, AuditEntry_Action as Action, type AuditEntry } from '../gen/enfilade/v1/site_service_pb';
import { changesIn, mayTakeBack, transactionOf } from './audited';
import { inverseOf } from './inverse';
import { linkPoint, linkPointName, mapName, scanner, titleOf } from './testing';

const now = 1_800_000_000_000;
const byHandCovariance = [0.01, 0, 0, 0, 0.01, 0, 0, 0, 0.001];

// As the database writes rows.
const row = (rest: object = {}) => ({ site_id: 's', link_point_id: 'door', kind: 1, tag: '', direction_map_id: null, difficulty: 0, environment: 0, state: 1, valid_until: null, use: 1, forced: false, pinned: false, ...rest });
const anchorRow = (map: string, x: number, y: number, yaw: number, covariance = scanner, ordinal = 1) => ({ site_id: 's', link_point_id: 'door', map_id: map, ordinal, x, y, yaw, covariance });

function entry(resource: string, before: object | undefined, after: object | undefined, time = now, actor = 'anna'): AuditEntry {
  const action = before === undefined ? Action.CREATED : after === undefined ? Action.DELETED : Action.UPDATED;
  return create(AuditEntrySchema, { time: timestampFromMs(time), actor, action, resource, before: before ? JSON.stringify(before) : '', after: after ? JSON.stringify(after) : '' });
}

const name = linkPointName('door');
const takenBack = (entries: AuditEntry[], present: LinkPoint | undefined) => inverseOf(changesIn(transactionOf(entries, entries[0]!)), new Map([[name, present]]), titleOf);
const cases = (inverse: ReturnType<typeof takenBack>) => inverse.changes.map(({ change }) => change.case);

test('a moved anchor goes back to where it was, with the covariance that it had and the etag that it has', () => {
  const entries = [entry(`${name}/anchors/b`, anchorRow('b', 3, 4, 1), anchorRow('b', 5, 6, 0.5, byHandCovariance)), entry(name, row(), row())];
  const present = linkPoint('door', { a: [1, 2, 0], b: [5, 6, 0.5] }, { etag: '"9"' });
  present.anchors[1]!.poseMapPlace!.covariance = byHandCovariance;
  const inverse = takenBack(entries, present);
  expect(cases(inverse)).toEqual(['updated']);
  const wanted = inverse.changes[0]!.change.value as LinkPoint;
  expect(wanted.etag).toBe('"9"');
  expect(wanted.anchors[0]).toEqual(present.anchors[0]);
  expect(wanted.anchors[1]?.poseMapPlace?.pose).toMatchObject({ x: 3, y: 4, yaw: 1 });
  expect(wanted.anchors[1]?.poseMapPlace?.covariance).toEqual(scanner);
  expect(inverse.changes[0]!.updateMask?.paths).toEqual(['anchors']);
  expect([...inverse.warnings, ...inverse.refusals]).toEqual([]);
  expect(inverse.lines).toEqual(['door: its anchor in b goes back to 3.00, 4.00 m']);
});

test('what somebody has changed since is named, and stays', () => {
  const entries = [entry(`${name}/anchors/b`, anchorRow('b', 3, 4, 1), anchorRow('b', 5, 6, 0.5))];
  const inverse = takenBack(entries, linkPoint('door', { a: [1, 2, 0], b: [7, 7, 7] }));
  expect(inverse.refusals).toEqual(['door: its anchor in b has been changed since. Take that back first, or change it on the campus.']);
  const tag = takenBack([entry(name, row({ tag: 'old' }), row({ tag: 'new' }))], linkPoint('door', { a: [1, 2, 0] }, { tag: 'newer' }));
  expect(tag.refusals).toHaveLength(1);
  const made = takenBack([entry(`${name}/anchors/a`, undefined, anchorRow('a', 1, 2, 0)), entry(name, undefined, row())], linkPoint('door', { a: [1, 2, 0], b: [0, 0, 0] }));
  expect(made.refusals).toEqual(['door: it has been changed since. Take that back first, or change it on the campus.']);
});

test('a promotion is taken back by taking the anchor away', () => {
  const entries = [entry(`${name}/anchors/b`, undefined, anchorRow('b', 3, 4, 1)), entry(name, row(), row())];
  const inverse = takenBack(entries, linkPoint('door', { a: [1, 2, 0], b: [3, 4, 1] }));
  expect((inverse.changes[0]!.change.value as LinkPoint).anchors.map(({ map }) => map)).toEqual([mapName('a')]);
});

test('what was created is deleted, under its etag', () => {
  const entries = [entry(`${name}/anchors/a`, undefined, anchorRow('a', 1, 2, 0)), entry(name, undefined, row())];
  const inverse = takenBack(entries, linkPoint('door', { a: [1, 2, 0] }, { etag: '"9"' }));
  expect(inverse.changes.map(({ change, etag }) => [change.case, etag])).toEqual([['deleted', '"9"']]);
  expect(inverse.refusals).toEqual([]);
});

test('what was deleted is made again under its name, with its anchors in their order and its suspension', () => {
  const entries = [
    entry(`${name}/evidence/a/1`, { sha256: 'x' }, undefined), entry(`${name}/anchors/b`, anchorRow('b', 3, 4, 1, scanner, 2), undefined), entry(`${name}/anchors/a`, anchorRow('a', 1, 2, 0), undefined),
    entry(name, row({ forced: true, use: 3, kind: 2, state: 3, difficulty: 4, tag: 'freight', direction_map_id: 'b', valid_until: '2027-01-02T03:04:05+00:00' }), undefined),
  ];
  const inverse = takenBack(entries, undefined);
  expect(cases(inverse)).toEqual(['created', 'suspended']);
  expect(inverse.changes[0]!.force).toBe(true);
  const made = inverse.changes[0]!.change.value as LinkPoint;
  expect(made).toMatchObject({ name, kind: Kind.LIFT, state: State.BLOCKED, difficulty: 4, tag: 'freight', directionMap: mapName('b') });
  expect(made.stateValidUntil?.seconds).toBe(BigInt(Date.UTC(2027, 0, 2, 3, 4, 5) / 1000));
  expect(made.anchors.map(({ map }) => map)).toEqual([mapName('a'), mapName('b')]);
  expect(inverse.warnings).toEqual(['door: its pictures and clouds are gone and do not come back.']);
  expect(takenBack(entries, linkPoint('door', { a: [1, 2, 0] })).changes).toEqual([]);
});

test('a suspension, a kind, a state and a tag go back to what they were', () => {
  const entries = [entry(name, row(), row({ use: 3, kind: 5, state: 2, tag: 'new', difficulty: 2 }))];
  const present = linkPoint('door', { a: [1, 2, 0], b: [3, 4, 1] }, { use: 'USE_SUSPENDED', kind: 'KIND_OPENING', state: 'STATE_CLOSED', tag: 'new', difficulty: 2 });
  const inverse = takenBack(entries, present);
  expect(cases(inverse)).toEqual(['updated', 'resumed']);
  expect(inverse.changes[0]!.change.value).toMatchObject({ kind: Kind.DOOR, state: State.OPEN, tag: '', difficulty: 0 });
  expect(inverse.lines).toContain('door is resumed');
});

test('the pin that a move has set goes with it, and one of before stays', () => {
  const moved = entry(`${name}/anchors/a`, anchorRow('a', 1, 2, 0), anchorRow('a', 5, 6, 0.5));
  const present = linkPoint('door', { a: [5, 6, 0.5], b: [3, 4, 1] }, { pinned: true });
  const inverse = takenBack([moved, entry(name, row(), row({ pinned: true }))], present);
  expect(inverse.changes[0]!.change.value).toMatchObject({ pinned: false });
  expect(inverse.changes[0]!.updateMask?.paths).toEqual(['anchors', 'pinned']);
  expect(inverse.lines).toContain('door: it is pinned no more');
  const before = takenBack([moved, entry(name, row({ pinned: true }), row({ pinned: true }))], present);
  expect(before.changes[0]!.updateMask?.paths).toEqual(['anchors']);
  const since = takenBack([entry(name, row(), row({ pinned: true }))], linkPoint('door', { a: [1, 2, 0] }));
  expect(since.refusals).toEqual(['door: its pin has been changed since. Take that back first, or change it on the campus.']);
});

test('a tag alone is a change, too', () => {
  const inverse = takenBack([entry(name, row({ tag: 'old' }), row({ tag: 'new' }))], linkPoint('door', { a: [1, 2, 0] }, { tag: 'new' }));
  expect(cases(inverse)).toEqual(['updated']);
  expect(inverse.changes[0]!.change.value).toMatchObject({ tag: 'old', etag: '"5"' });
  expect(inverse.changes[0]!.updateMask?.paths).toEqual(['tag']);
});

test('several rows of one transaction count from the first to the last, those of others not at all', () => {
  const entries = [
    entry(name, row({ use: 1 }), row({ use: 3 })), entry(name, row({ kind: 1 }), row({ kind: 4 })),
    entry(name, row({ kind: 3 }), row({ kind: 1 }), now - 5000), entry(linkPointName('lift'), row(), row({ kind: 5 }), now, 'ben'),
  ];
  const changes = changesIn(transactionOf(entries, entries[0]!));
  expect(changes).toHaveLength(1);
  expect(changes[0]?.row?.before).toMatchObject({ kind: 1 });
  expect(changes[0]?.row?.after).toMatchObject({ use: 3 });
});

test('what has gone meanwhile is told, and nothing is made of rows that are not as expected', () => {
  const moved = [entry(`${name}/anchors/b`, anchorRow('b', 3, 4, 1), anchorRow('b', 5, 6, 0.5))];
  expect(takenBack(moved, undefined)).toMatchObject({ changes: [], refusals: ['door has been deleted since. Take back its deletion first.'] });
  const odd = [entry(name, row(), undefined), entry(`${name}/anchors/a`, { x: 'far' }, undefined)];
  expect(takenBack(odd, undefined)).toMatchObject({ changes: [], refusals: ['door: the audit trail does not have its anchors, so it cannot come back.'] });
});

test('only places and their anchors can be taken back', () => {
  expect([name, `${name}/anchors/a`, `${name}/evidence/a/1`, mapName('a'), 'sites/s'].map((resource) => mayTakeBack({ resource }))).toEqual([true, true, false, false, false]);
});
