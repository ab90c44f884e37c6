// SPDX-License-Identifier: Apache-2.0
import { expect, test } from 'vitest';
import { cellColours, defaultClasses, parseColour, rgba } from './palette';

test('reads colours as style sheets have them, also shortened', () => {
  expect(parseColour(' #2456c9')).toEqual([0x24, 0x56, 0xc9]);
  expect(parseColour('#fa0')).toEqual([255, 170, 0]);
  expect(() => parseColour('red')).toThrow(/"red"/);
});

test('packs a colour as bytes in the order r, g, b, a', () => {
  expect([...new Uint8Array(Uint32Array.of(rgba([1, 2, 3], 1)).buffer)]).toEqual([1, 2, 3, 255]);
});

test('draws nothing for what is unknown, and tells free from occupied by alpha', () => {
  const cells = cellColours(defaultClasses, [255, 255, 255], [0, 0, 0]);
  const alpha = (value: number) => cells[4 * value + 3];
  expect([0, 1, 128, 255].map(alpha)).toEqual([0, 128, 0, 255]);
  expect([...cells.subarray(4, 7)]).toEqual([255, 255, 255]);
  expect([...cells.subarray(4 * 255, 4 * 255 + 3)]).toEqual([0, 0, 0]);
});
