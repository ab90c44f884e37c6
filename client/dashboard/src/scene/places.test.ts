// SPDX-License-Identifier: Apache-2.0
import { fromJson } from '@bufbuild/protobuf';
import { expect, test } from 'vitest';
import { WatchSiteResponseSchema } from '../gen/enfilade/v1/watch_service_pb';
import { LiveSite } from '../live/site';
import type { Pose } from './camera';
import { eachPlace, placeOfMap, shiftedPlace } from './places';
import { chained, placedBy, relative, reversed, samePose } from './se2';

const site = new LiveSite('s');
site.apply(
  fromJson(WatchSiteResponseSchema, {
    graph: { rootMap: 'sites/s/maps/a', maps: [{ map: 'sites/s/maps/a', poseWorldMap: { pose: {} } }, { map: 'sites/s/maps/b', poseWorldMap: { pose: { x: 10, yaw: 1.5707963267948966 } } }, { map: 'sites/s/maps/c' }] },
  }),
  0,
);
const [a, b, c] = ['a', 'b', 'c'].map((id) => `sites/s/maps/${id}`) as [string, string, string];

test('shifted maps are drawn where the page says, also those that the graph does not place', () => {
  const shifted = new Map<string, Pose>([[b, { x: 1, y: 2, yaw: 0 }], [c, { x: 5, y: 5, yaw: 0 }]]);
  const found = new Map<string, Pose>();
  eachPlace(site, { shifted }, (map, pose) => found.set(map, pose));
  expect(found.get(a)).toMatchObject({ x: 0, y: 0, yaw: 0 });
  expect(found.get(b)).toEqual({ x: 1, y: 2, yaw: 0 });
  expect(found.get(c)).toEqual({ x: 5, y: 5, yaw: 0 });
  expect(placeOfMap(site, { shifted }, b)).toEqual({ x: 1, y: 2, yaw: 0 });
});

test('what lies in a shifted map goes with it, turned as it is', () => {
  const shifted = new Map<string, Pose>([[b, { x: 0, y: 0, yaw: 0 }]]);
  const place = { x: 10, y: 3, yaw: Math.PI / 2 };
  expect(samePose(shiftedPlace(site, { shifted }, [a, b], place), { x: 3, y: 0, yaw: 0 }, 1e-12)).toBe(true);
  expect(shiftedPlace(site, { shifted }, [a], place)).toBe(place);
});

test('poses are transforms', () => {
  const [p, q] = [{ x: 1, y: 2, yaw: 3 }, { x: -4, y: 0.5, yaw: 2 }];
  expect(samePose(chained(p, reversed(p)), { x: 0, y: 0, yaw: 0 }, 1e-12)).toBe(true);
  expect(samePose(chained(p, relative(p, q)), q, 1e-12)).toBe(true);
  const there = placedBy(p, { x: 1, y: 0 });
  expect(there.x).toBeCloseTo(1 + Math.cos(3), 12);
  expect(there.y).toBeCloseTo(2 + Math.sin(3), 12);
});
