// SPDX-License-Identifier: Apache-2.0
import { expect, test } from 'vitest';
import { affineOf } from '../affine';
import { coverOf } from './cover';
import { at, type Manifest, type Thumbnail, zoomFor } from './manifest';

// 4 x 4 tiles around the origin of the lattice, 5 cm, with two coarser levels.
const level = (name: string, from: number, to: number) =>
  Array.from({ length: (to - from) ** 2 }, (_, i) => {
    const [row, column] = [from + Math.floor(i / (to - from)), from + (i % (to - from))];
    return { row, column, key: `${name}${row}${column}` };
  });
const levels = [level('a', -2, 2), level('b', -1, 1), level('c', -1, 1)];
const manifest: Manifest = {
  revision: 'r', resolution: 0.05, pose: { x: 0, y: 0, yaw: 0 }, classes: new Uint8Array(256), levels,
  index: levels.map((tiles) => new Map(tiles.map(({ row, column, key }) => [at(row, column), key]))),
};
const here = affineOf({ x: 0, y: 0, yaw: 0 });
const all = { minX: -100, minY: -100, maxX: 100, maxY: 100 };
const thumbnail: Thumbnail = {
  revision: 'r', resolution: 0.8, pose: { x: -25.6, y: -25.6, yaw: 0 }, width: 64, height: 64, cells: new Uint8Array(4096), layer: 0, middle: { x: 32, y: 32 },
};

test('takes the zoom at which a cell is at least a pixel', () => {
  expect([1000, 20, 19, 10, 9, 0.1].map((scale) => zoomFor(manifest, scale))).toEqual([0, 0, 1, 1, 2, 2]);
});

test('draws the tiles of the zoom if all are there', () => {
  const { patches, missing } = coverOf(manifest, thumbnail, here, all, 20, () => true);
  expect(missing).toEqual([]);
  expect(patches).toHaveLength(16);
  expect(patches[0]).toEqual({ x0: -25.6, y0: -25.6, x1: -12.8, y1: -12.8, key: 'a-2-2', u0: 0, v0: 0, u1: 256, v1: 256 });
});

test('wants only what is in view, also of a map that is turned', () => {
  const turned = affineOf({ x: 1000, y: 0, yaw: Math.PI / 2 });
  const { missing } = coverOf(manifest, undefined, turned, { minX: 990, minY: 5, maxX: 995, maxY: 10 }, 20, () => false);
  expect(missing).toEqual(['a00']);
});

test('takes the part of a coarser tile where one is missing, also below 0', () => {
  const { patches } = coverOf(manifest, thumbnail, here, all, 20, (key) => key.startsWith('b'));
  const patch = (row: number, column: number) => patches.find(({ x0, y0 }) => x0 === column * 12.8 && y0 === row * 12.8);
  expect(patch(-2, -1)).toMatchObject({ key: 'b-1-1', u0: 128, v0: 0, u1: 256, v1: 128 });
  expect(patch(1, 0)).toMatchObject({ key: 'b00', u0: 0, v0: 128, u1: 128, v1: 256 });
});

test('takes the part of the thumbnail where nothing else is there', () => {
  const { patches, missing } = coverOf(manifest, thumbnail, here, all, 20, () => false);
  expect(missing).toHaveLength(16);
  expect(patches[5]).toMatchObject({ key: undefined, x0: -12.8, y0: -12.8, u0: 16, v0: 16, u1: 32, v1: 32 });
});

test('cuts what the thumbnail does not have', () => {
  const small = { ...thumbnail, width: 20, height: 8 };
  const { patches } = coverOf(manifest, small, here, all, 20, () => false);
  expect(patches).toHaveLength(2);
  expect(patches[1]).toMatchObject({ x0: -12.8, y0: -25.6, u0: 16, u1: 20, v0: 0, v1: expect.closeTo(8) });
  expect(patches[1]!.x1).toBeCloseTo(-9.6);
});
