// SPDX-License-Identifier: Apache-2.0
import { create, fromJson, type JsonValue } from '@bufbuild/protobuf';
import { expect, test, vi } from 'vitest';
import { WatchSiteResponseSchema } from '../gen/enfilade/v1/watch_service_pb';
import { LiveSite } from './site';

const message = (json: JsonValue) => fromJson(WatchSiteResponseSchema, json);
const robot = (id: string, x: number, more: Record<string, JsonValue> = {}) => ({
  robot: `sites/s/robots/${id}`, map: 'sites/s/maps/m', poseMapRobot: { x }, poseWorldRobot: { x: x + 100 },
  covariance: [1, 0.5, 2, 0.1], receiveTime: '2026-01-01T00:00:10Z', ...more,
});

test('keeps robots by their whole name, and the last pose of each', () => {
  const site = new LiveSite('s');
  site.apply(message({ robots: [robot('a', 1), robot('b', 2)] }), 0);
  site.apply(message({ robots: [robot('a', 3)] }), 0);
  expect(site.robots.count).toBe(2);
  expect(site.robots.get('sites/s/robots/a')).toMatchObject({ poseMap: { x: 3 }, poseWorld: { x: 103 }, covariance: [1, 0.5, 2, expect.closeTo(0.1)] });
});

test('gives the row of a removed robot to the last one', () => {
  const site = new LiveSite('s');
  site.apply(message({ robots: [robot('a', 1), robot('b', 2), robot('c', 3)] }), 0);
  site.apply(message({ removedRobots: ['sites/s/robots/a', 'sites/s/robots/unknown'] }), 0);
  expect(site.robots.all().map(({ name, poseMap }) => [name, poseMap.x])).toEqual([['sites/s/robots/c', 3], ['sites/s/robots/b', 2]]);
  expect(site.robots.rowOf('sites/s/robots/c')).toBe(0);
});

test('grows beyond its first capacity without losing poses', () => {
  const site = new LiveSite('s');
  site.apply(message({ robots: Array.from({ length: 500 }, (_, i) => robot(`r${i}`, i)) }), 0);
  expect(site.robots.all().every(({ name, poseMap }, i) => name === `sites/s/robots/r${i}` && poseMap.x === i)).toBe(true);
});

test('says that a robot has no place in the world', () => {
  const site = new LiveSite('s');
  site.apply(create(WatchSiteResponseSchema, { robots: [{ robot: 'sites/s/robots/a', poseMapRobot: { x: 1 } }] }), 0);
  expect(site.robots.get('sites/s/robots/a')?.poseWorld).toBeUndefined();
});

test('removes before it adds, so that a change can replace', () => {
  const site = new LiveSite('s');
  site.apply(message({ graph: { graphVersion: '1', maps: [{ map: 'sites/s/maps/m', level: 1 }] }, rasters: [{ map: 'sites/s/maps/m', revision: 'sites/s/maps/m/revisions/1' }] }), 0);
  site.apply(message({ graph: { graphVersion: '2', removedMaps: ['sites/s/maps/m'], maps: [{ map: 'sites/s/maps/n', level: 2 }] } }), 0);
  expect([...site.maps.keys()]).toEqual(['sites/s/maps/n']);
  expect(site.rasters.size).toBe(0);
  expect(site.graphVersion).toBe(2n);
  expect(site.levels()).toEqual([2]);
});

test('forgets all at a reset, and keeps all when the stream goes on', () => {
  const site = new LiveSite('s');
  site.apply(message({ start: { reset: true }, robots: [robot('a', 1)] }), 0);
  site.apply(message({ start: {}, robots: [robot('b', 1)] }), 0);
  expect(site.robots.count).toBe(2);
  site.apply(message({ start: { reset: true }, robots: [robot('c', 1)] }), 0);
  expect(site.robots.all().map(({ name }) => name)).toEqual(['sites/s/robots/c']);
});

test('is complete when the last part of the start has come', () => {
  const site = new LiveSite('s');
  site.apply(message({ start: { reset: true }, more: true }), 0);
  expect(site.complete).toBe(false);
  site.apply(message({ robots: [robot('a', 1)] }), 0);
  expect(site.complete).toBe(true);
});

test("tells ages by the server's clock, whatever this one shows", () => {
  const site = new LiveSite('s');
  const now = Date.parse('2031-05-05T00:00:00Z');
  site.apply(message({ sendTime: '2026-01-01T00:00:12Z', robots: [robot('a', 1)] }), now);
  expect(site.ageOf(site.robots.at(0).receiveTime, now + 1000)).toBe(3);
});

test('tells its subscribers at most four times a second', () => {
  vi.useFakeTimers({ now: 100_000 });
  const site = new LiveSite('s');
  let told = 0;
  site.subscribe(() => ++told);
  for (let i = 0; i < 40; ++i) {
    site.apply(message({ robots: [robot('a', i)] }), 0);
    vi.advanceTimersByTime(25);
  }
  vi.advanceTimersByTime(250);
  expect(told).toBeGreaterThanOrEqual(4);
  expect(told).toBeLessThanOrEqual(5);
  vi.useRealTimers();
});
