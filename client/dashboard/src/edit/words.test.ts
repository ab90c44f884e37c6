// SPDX-License-Identifier: Apache-2.0
import { expect, test } from 'vitest';
import { cellText, thresholdsText } from './words';

test('says what a cell is, and whether a person says so', () => {
  expect(cellText(0)).toBe('unknown');
  expect(cellText(1)).toBe('free');
  expect(cellText(2)).toBe('occupied');
  expect(cellText(2 | (2 << 2))).toBe('free, edited');
});

test('says by which shares cells are free and occupied', () => {
  const classes = Uint8Array.from({ length: 256 }, (_, value) => (value === 0 ? 0 : value >= 166 ? 2 : value <= 64 ? 1 : 0));
  expect(thresholdsText(classes)).toBe('occupied from 65 %, free up to 25 %, and unknown between');
  expect(thresholdsText(new Uint8Array(256))).toBeUndefined();
});
