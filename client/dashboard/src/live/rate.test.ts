// SPDX-License-Identifier: Apache-2.0
import { expect, test } from 'vitest';
import { Rate } from './rate';

test('tells how fast a count grows lately', () => {
  const rate = new Rate();
  expect(rate.perSecond(0)).toBe(0);
  for (let s = 0; s <= 30; ++s) rate.add(1000 * s, s < 10 ? 0 : 50 * (s - 10));
  expect(rate.perSecond(30_000)).toBeCloseTo(50);
});

test('falls while nothing comes, to nothing', () => {
  const rate = new Rate();
  for (let s = 0; s <= 10; ++s) rate.add(1000 * s, 50 * s);
  expect(rate.perSecond(15_000)).toBeCloseTo(500 / 15);
  expect(rate.perSecond(20_001)).toBe(0);
});

test('needs two moments', () => {
  const rate = new Rate();
  rate.add(0, 100);
  expect(rate.perSecond(1)).toBe(0);
});
