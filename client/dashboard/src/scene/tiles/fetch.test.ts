// SPDX-License-Identifier: Apache-2.0
import { expect, test } from 'vitest';
import { parseOverview, parseTiles } from './fetch';
import { middleOf } from './manifest';

test('reads the index and the cells of the overview', () => {
  const head = new TextEncoder().encode('{"thumbnails":[{"revision":"a","resolutionM":0.5,"x":1,"y":2,"yaw":3,"width":2,"height":1,"offset":0},{"revision":"b","resolutionM":1,"width":1,"height":1,"offset":2}]}\n');
  const [first, second] = parseOverview(Uint8Array.of(...head, 0, 2, 1));
  expect(first).toMatchObject({ revision: 'a', resolution: 0.5, pose: { x: 1, y: 2, yaw: 3 }, cells: Uint8Array.of(0, 255) });
  expect(second?.cells).toEqual(Uint8Array.of(1));
});

test('reads tiles that come in pieces of any size', () => {
  const frame = (id: number, cells: number[]) => [...Array<number>(32).fill(id), cells.length, 0, 0, 0, ...cells];
  const all = Uint8Array.of(...frame(1, [7, 8, 9]), ...frame(2, []), ...frame(3, [5]));
  for (const size of [1, 35, 36, 40, 200]) {
    const found: [string, number[]][] = [];
    let rest = new Uint8Array();
    for (let at = 0; at < all.length; at += size) {
      const parsed = parseTiles(Uint8Array.of(...rest, ...all.subarray(at, at + size)));
      for (const [key, cells] of parsed.tiles) found.push([key.slice(0, 2), [...cells]]);
      rest = Uint8Array.from(parsed.rest);
    }
    expect(found).toEqual([['01', [7, 8, 9]], ['02', []], ['03', [5]]]);
    expect(rest).toHaveLength(0);
  }
});

test('names a map where it is widest, not where it looks through a door', () => {
  const rows = ['2222222222222', '2111112111111', '2111111111111', '2111112111111', '2111112222222', '2111112000000', '2222222000000'];
  const cells = Uint8Array.from(rows.join(''), (digit) => (digit === '2' ? 255 : Number(digit)));
  const { x, y } = middleOf(cells, 13);
  expect(x).toBeGreaterThan(1);
  expect(x).toBeLessThan(6);
  expect(y).toBeGreaterThan(1);
  expect(y).toBeLessThan(6);
});
