// SPDX-License-Identifier: Apache-2.0
import { fromJson } from '@bufbuild/protobuf';
import { expect, test } from 'vitest';
import { WatchSiteResponseSchema } from '../gen/enfilade/v1/watch_service_pb';
import { LiveSite } from './site';
import { unplacedOf } from './unplaced';

const site = new LiveSite('s');
site.apply(
  fromJson(WatchSiteResponseSchema, {
    graph: {
      rootMap: 'sites/s/maps/root',
      maps: [
        { map: 'sites/s/maps/root', displayName: 'Root', poseWorldMap: { pose: {} } },
        { map: 'sites/s/maps/lone', displayName: 'Lone' },
        { map: 'sites/s/maps/up', displayName: 'Up', level: 1 },
        { map: 'sites/s/maps/bare', displayName: 'Bare', level: 2, poseWorldMap: { pose: {} } },
      ],
      linkPoints: [{ linkPoint: 'sites/s/linkPoints/p', maps: ['sites/s/maps/up'] }],
    },
    rasters: ['root', 'lone', 'up'].map((map) => ({ map: `sites/s/maps/${map}`, revision: `sites/s/maps/${map}/revisions/1` })),
    robots: [
      { robot: 'sites/s/robots/a', map: 'sites/s/maps/root', poseWorldRobot: {} },
      { robot: 'sites/s/robots/b', map: 'sites/s/maps/up', level: 1 },
    ],
  }),
  0,
);

test('lists maps and robots without a place, with the reason', () => {
  expect(unplacedOf(site, undefined).map(({ title, reason }) => [title, reason.slice(0, 30)])).toEqual([
    ['Lone', 'It has no link points. Drive a'],
    ['Up', 'Its link points join it to no '],
    ['Bare', 'Nothing is mapped in it yet. D'],
    ['b', 'Its map “Up” is not joined to '],
  ]);
});

test('keeps to the level', () => {
  expect(unplacedOf(site, 0).map(({ title }) => title)).toEqual(['Lone']);
});
