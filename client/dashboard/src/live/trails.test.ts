// SPDX-License-Identifier: Apache-2.0
import { fromJson, type JsonValue } from '@bufbuild/protobuf';
import { expect, test } from 'vitest';
import { WatchSiteResponseSchema } from '../gen/enfilade/v1/watch_service_pb';
import { LiveSite } from './site';

const robot = 'sites/s/robots/r';
const begin = Date.parse('2026-01-01T00:00:00Z');

interface Report {
  second: number;
  x: number;
  map?: string;
  // Of the map in the world; null: it has no place there.
  at?: number | null;
}

function report(site: LiveSite, { second, x, map = 'm', at = 0 }: Report) {
  const time = new Date(begin + 1000 * second).toISOString();
  const state: Record<string, JsonValue> = { robot, map: `sites/s/maps/${map}`, poseMapRobot: { x }, reportTime: time, receiveTime: time };
  if (at !== null) state.poseWorldRobot = { x: at + x };
  site.apply(fromJson(WatchSiteResponseSchema, { robots: [state] }), 0);
}

function placesOf(site: LiveSite): [map: string, x: number, joined: boolean][] {
  const places: [string, number, boolean][] = [];
  site.trails.of(robot)?.walk((map, x, _y, _time, joined) => (places.push([map.split('/').at(-1)!, Math.round(1000 * x) / 1000, joined]), true));
  return places;
}

const after = (...reports: Report[]) => {
  const site = new LiveSite('s');
  for (const one of reports) report(site, one);
  return site;
};

test('keeps a place where the robot has gone a step, the newest first', () => {
  const site = after({ second: 0, x: 0 }, { second: 1, x: 0.1 }, { second: 2, x: 0.4 }, { second: 3, x: 0.5 }, { second: 4, x: 0.8 });
  expect(placesOf(site)).toEqual([['m', 0.8, true], ['m', 0.4, true], ['m', 0, false]]);
});

test('a robot that stands still for long goes on from where it stood', () => {
  const site = after({ second: 0, x: 0 }, { second: 8, x: 0 }, { second: 16, x: 0.1 }, { second: 17, x: 1 });
  expect(placesOf(site)).toEqual([['m', 1, true], ['m', 0, false]]);
});

test('breaks where the pose jumps, and where nothing came for long', () => {
  expect(placesOf(after({ second: 0, x: 0 }, { second: 1, x: 30 }))).toEqual([['m', 30, false], ['m', 0, false]]);
  expect(placesOf(after({ second: 0, x: 0 }, { second: 60, x: 1 }))).toEqual([['m', 1, false], ['m', 0, false]]);
});

test('goes through a door where both maps have a place in the world, and the places meet', () => {
  const into = (at: number | null) => placesOf(after({ second: 0, x: 4.9 }, { second: 1, x: 0.1, map: 'n', at }));
  expect(into(5)).toEqual([['n', 0.1, true], ['m', 4.9, false]]);
  expect(into(50)).toEqual([['n', 0.1, false], ['m', 4.9, false]]);
  expect(into(null)).toEqual([['n', 0.1, false], ['m', 4.9, false]]);
});

test('is bounded, and keeps the newest', () => {
  const site = new LiveSite('s');
  for (let i = 0; i < 1000; ++i) report(site, { second: i, x: i });
  const places = placesOf(site);
  expect(places.length).toBe(128);
  expect(places[0]).toEqual(['m', 999, true]);
  expect(places.at(-1)).toEqual(['m', 872, true]);
});

test('goes with the robot, and with a reset', () => {
  const site = after({ second: 0, x: 0 });
  site.apply(fromJson(WatchSiteResponseSchema, { removedRobots: [robot] }), 0);
  expect(placesOf(site)).toEqual([]);
  report(site, { second: 1, x: 0 });
  site.apply(fromJson(WatchSiteResponseSchema, { start: { reset: true } }), 0);
  expect(placesOf(site)).toEqual([]);
});
