// SPDX-License-Identifier: Apache-2.0
import { create } from '@bufbuild/protobuf';
import { expect, test } from 'vitest';
import { MapAliasSchema } from '../../gen/enfilade/v1/map_pb';
import { MapDiffRegionSchema } from '../../gen/enfilade/v1/map_service_pb';
import { beforeOf, diffLines, isAliasName, kindOf, middleOf, offeredAliases, sizeOf } from './versions';

const map = 'sites/s/maps/hall';
const alias = (id: string, revision: number, before = 0) =>
  create(MapAliasSchema, { name: `${map}/aliases/${id}`, revision: `${map}/revisions/${revision}`, ...(before > 0 && { previousRevision: `${map}/revisions/${before}` }) });

test('offers the usual aliases and those that are there, unless they lead there already', () => {
  expect(offeredAliases([], `${map}/revisions/3`)).toEqual(['stable', 'canary']);
  expect(offeredAliases([alias('stable', 3), alias('night-shift', 2)], `${map}/revisions/3`)).toEqual(['canary', 'night-shift']);
});

test('knows where an alias can be led back to', () => {
  expect(beforeOf(alias('stable', 3))).toBeUndefined();
  expect(beforeOf(alias('stable', 3, 2))).toBe('2');
});

test('takes the names that the server takes', () => {
  for (const name of ['stable', 'v2-1', 'a'.repeat(63)]) expect(isAliasName(name)).toBe(true);
  for (const name of ['', 'Stable', 'a b', 'ä', 'a'.repeat(64)]) expect(isAliasName(name)).toBe(false);
});

test('says in square metres what came and went', () => {
  // From unknown, free, occupied.
  const cells = [900, 40, 8, 10, 500, 12, 3, 17, 100].map(BigInt);
  expect(diffLines({ cells, resolutionM: 0.5 })).toEqual([
    { title: 'Walls that came', cells: 20, area: 5 },
    { title: 'Walls that went', cells: 20, area: 5 },
    { title: 'Ground newly seen', cells: 40, area: 10 },
    { title: 'Ground no longer known', cells: 10, area: 2.5 },
  ]);
  expect(diffLines({ cells: [900, 0, 0, 0, 500, 0, 0, 0, 100].map(BigInt), resolutionM: 0.5 })).toEqual([]);
});

test('tells what a region has become, where it is and how large', () => {
  const corners = [{ x: 1, y: 2 }, { x: 3, y: 2 }, { x: 3, y: 7 }, { x: 1, y: 7 }];
  const region = create(MapDiffRegionSchema, { box: { corners }, cells: 10n, toOccupied: 3n, toFree: 6n, toUnknown: 1n });
  expect(kindOf(region)).toBe('Free now');
  expect(kindOf({ toOccupied: 3n, toFree: 0n, toUnknown: 3n })).toBe('Occupied now');
  expect(kindOf({ toOccupied: 0n, toFree: 0n, toUnknown: 3n })).toBe('Unknown now');
  expect(middleOf(region)).toEqual({ x: 2, y: 4.5 });
  expect(sizeOf(region)).toEqual([2, 5]);
  expect(middleOf(create(MapDiffRegionSchema))).toBeUndefined();
});
