// SPDX-License-Identifier: Apache-2.0
import { create } from '@bufbuild/protobuf';
import { timestampFromMs, timestampMs } from '@bufbuild/protobuf/wkt';
import { expect, test } from 'vitest';
import { MapArea_Kind as Kind, MapAreaSchema } from '../gen/enfilade/v1/map_area_pb';
import { changedPaths, cornersText, differencesOf, exactly, fieldsOf, laidOver, messageOf, newFields, problemOf } from './areas';

const corners = [{ x: 0.12345678, y: 0 }, { x: 2, y: 0 }, { x: 1, y: 1.5 }];
const until = Date.UTC(2026, 11, 31, 18, 0, 5);
const lab = create(MapAreaSchema, { displayName: 'Lab', kind: Kind.SPEED_LIMIT, speedLimitMps: 0.3, robotTypes: ['cleaner', 'tug'], outline: { corners }, validUntil: timestampFromMs(until) });

test('what is entered comes back', () => {
  const fields = fieldsOf(lab);
  expect(problemOf(fields)).toBeUndefined();
  const message = messageOf(fields);
  expect(message).toMatchObject({ displayName: 'Lab', kind: Kind.SPEED_LIMIT, speedLimitMps: 0.3, robotTypes: ['cleaner', 'tug'], outline: { corners } });
  expect(timestampMs(message.validUntil!)).toBe(until);
  expect('validFrom' in message).toBe(false);
});

test('only what has changed is sent', () => {
  const fields = fieldsOf(lab);
  expect(changedPaths(fields, fieldsOf(lab))).toEqual([]);
  expect(changedPaths({ ...fields, title: 'Laboratory', until: '' }, fields)).toEqual(['display_name', 'valid_until']);
  const closed = { ...fields, kind: Kind.KEEP_OUT };
  expect(changedPaths(closed, fields)).toEqual(['kind', 'speed_limit_mps']);
  expect(messageOf(closed).speedLimitMps).toBe(0);
  expect(changedPaths({ ...fields, corners: corners.slice(1) }, fields)).toEqual(['outline']);
});

test('corners that are typed beside others leave these as they were', () => {
  const text = cornersText(corners);
  expect(text).toBe('0.123, 0; 2, 0; 1, 1.5');
  expect(exactly([{ x: 0.123, y: 0 }, { x: 2, y: 0.5 }, { x: 1, y: 1.5 }], corners)).toEqual([corners[0], { x: 2, y: 0.5 }, corners[2]]);
});

test('mine is laid over theirs field by field, and what they have changed is said', () => {
  const before = fieldsOf(lab);
  const theirs = { ...before, title: 'Laboratory', types: '', corners: [...corners, { x: 0, y: 1 }] };
  expect(differencesOf(before, theirs)).toEqual(['Name: Lab, now Laboratory', 'Robot types: cleaner, tug, now all', 'Outline: 3 corners, now 4']);
  expect(laidOver({ ...before, speed: '0.5', types: 'tug' }, before, theirs)).toEqual({ ...theirs, speed: '0.5', types: 'tug' });
});

test('what cannot be is told before it is sent', () => {
  const fields = fieldsOf(lab);
  expect(problemOf(newFields)).toBe('Enter a name.');
  expect(problemOf({ ...fields, corners: [] })).toMatch(/three corners/);
  expect(problemOf({ ...fields, speed: '-1' })).toMatch(/speed limit/);
  expect(problemOf({ ...fields, from: '2026-12-01T10:00', until: '2026-12-01T10:00' })).toMatch(/ends before/);
});
