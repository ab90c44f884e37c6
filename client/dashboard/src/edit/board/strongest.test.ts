// SPDX-License-Identifier: Apache-2.0
import { expect, test } from 'vitest';
import { FREE, OCCUPIED, shownOf, UNKNOWN } from '../cells';
import { TILE } from '../lattice';
import { strongest } from './strongest';

// What robots have seen, and what the draft says.
const seen = { unknown: 0, free: 1, occupied: 2 };
const draft = (value: number) => value << 2;

test('a wall of one cell is seen at every zoom', () => {
  const cells = new Uint8Array(TILE * TILE).fill(seen.free);
  for (let row = 0; row < TILE; ++row) cells[row * TILE + 77] = seen.occupied;
  for (let zoom = 0; zoom <= 8; ++zoom) {
    for (let row = 0; row < TILE >> zoom; ++row) expect(shownOf(strongest(cells, row, 77 >> zoom, zoom))).toBe(OCCUPIED);
    if (zoom > 0 && zoom < 7) expect(shownOf(strongest(cells, 0, (77 >> zoom) + 1, zoom))).toBe(FREE);
  }
});

test('occupied wins over free, free over unknown, and edits lie over what robots have seen', () => {
  const shown = (...some: number[]) => {
    const cells = new Uint8Array(TILE * TILE);
    [0, 1, TILE, TILE + 1].forEach((at, i) => (cells[at] = some[i]!));
    return shownOf(strongest(cells, 0, 0, 1));
  };
  expect(shown(seen.free, seen.occupied, seen.unknown, seen.free)).toBe(OCCUPIED);
  expect(shown(seen.unknown, seen.free, seen.unknown, seen.unknown)).toBe(FREE);
  expect(shown(seen.occupied | draft(FREE), seen.free, seen.free, seen.free)).toBe(FREE);
  expect(shown(seen.free | draft(OCCUPIED), seen.free, seen.free, seen.free)).toBe(OCCUPIED);
  expect(shown(...Array.from({ length: 4 }, () => seen.occupied | draft(UNKNOWN)))).toBe(UNKNOWN);
});
