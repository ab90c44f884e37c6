// SPDX-License-Identifier: Apache-2.0
import { create } from '@bufbuild/protobuf';
import { expect, test } from 'vitest';
import { MapLatticeSchema } from '../gen/enfilade/v1/map_edit_pb';
import { LatticeFrame } from './frame';
import { editsOf, parsePoints, type Wanted } from './numbers';
import { rasterised } from './raster/raster';
import type { Settings } from './tools/settings';

const frame = new LatticeFrame(create(MapLatticeSchema, { resolutionM: 0.1, poseMapLattice: { x: 1, y: -2, yaw: Math.PI / 2 } }));
const style = { value: 3, onlyWhere: [], invisible: false, author: 'me' } as const;
const settings: Settings = { tool: 'line', value: 3, size: 1, onlyWhere: [], invisible: false, isTinted: true };
const made = (wanted: Wanted, size = 1) => editsOf(wanted, frame, { firstColumn: 0, firstRow: 0, width: 9, height: 9 }, { ...settings, size }, { ...style, onlyWhere: [] });
const cells = (wanted: Wanted) => [...rasterised((made(wanted) as Exclude<ReturnType<typeof made>, string>)[0]!.shape)];

test('points are read with commas, spaces, semicolons and lines', () => {
  expect(parsePoints('1, 2; -3.5 4\n 5,6\n')).toEqual([{ x: 1, y: 2 }, { x: -3.5, y: 4 }, { x: 5, y: 6 }]);
  expect(parsePoints('1, 2, 3')).toContain('“1, 2, 3” is not a point');
  expect(parsePoints('one, 2')).toContain('not a point');
});

test('cells are those that are named', () => {
  expect(cells({ shape: 'line', measure: 'cells', text: '-1, 0; 1, 0' })).toEqual([0, -1, 2]);
  expect(cells({ shape: 'rectangle', measure: 'cells', text: '2, 1; 0, 2' })).toEqual([1, 0, 3, 2, 0, 3]);
  expect(cells({ shape: 'dot', measure: 'cells', text: '4, 5' })).toEqual([5, 4, 5]);
});

test('metres are those of the map, whatever its cells’ frame is', () => {
  // The map's x axis is the cells' -y axis.
  expect(cells({ shape: 'dot', measure: 'metres', text: '0.95, -1.75' })).toEqual([0, 2, 3]);
  expect(cells({ shape: 'rectangle', measure: 'metres', text: '1, -2; 0.8, -1.7' })).toEqual([0, 0, 3, 1, 0, 3]);
});

test('what cannot be drawn is said', () => {
  expect(made({ shape: 'line', measure: 'metres', text: '1, 2' })).toBe('A line takes at least 2 points, not 1.');
  expect(made({ shape: 'dot', measure: 'cells', text: '1.5, 2' })).toBe('Cells are counted in whole numbers.');
  expect(made({ shape: 'dot', measure: 'cells', text: '3000000, 2' })).toContain('too far away');
  expect(made({ shape: 'polygon', measure: 'cells', text: '0,0; 9,9; 9,0; 0,9' })).toBe('Sides 1 and 3 cross: put the corners in order.');
});

test('a thick line is a straight stroke of the brush', () => {
  const [edit] = made({ shape: 'line', measure: 'cells', text: '0,0; 5,0' }, 4) as Exclude<ReturnType<typeof made>, string>;
  expect(edit!.shape).toMatchObject({ case: 'brush', value: { radius: 512 } });
});
