// SPDX-License-Identifier: Apache-2.0
import { expect, test } from 'vitest';
import { byHand, covarianceOf, presets, SMALLEST_M, SMALLEST_RAD, spreadOf, spreadText, tidied } from './spread';

const RAD = Math.PI / 180;

// Deterministic, in [0, 1).
function numbers(seed: number) {
  let state = seed;
  return () => {
    state = (state * 1664525 + 1013904223) % 2 ** 32;
    return state / 2 ** 32;
  };
}

test('an ellipse and a wedge come back out of their covariance, whatever their direction', () => {
  const next = numbers(22);
  for (let i = 0; i < 500; ++i) {
    const minor = 0.01 + next();
    const spread = { major: minor + 0.01 + next(), minor, angle: (next() - 0.5) * Math.PI, yaw: 0.001 + next() };
    const back = spreadOf(covarianceOf(spread));
    expect(back.major).toBeCloseTo(spread.major, 10);
    expect(back.minor).toBeCloseTo(spread.minor, 10);
    expect(Math.cos(2 * (back.angle - spread.angle))).toBeCloseTo(1, 10);
    expect(back.yaw).toBeCloseTo(spread.yaw, 12);
  }
});

test('covariances are symmetric to the last bit and positive definite', () => {
  const next = numbers(7);
  for (let i = 0; i < 200; ++i) {
    const c = covarianceOf(tidied({ major: next(), minor: next(), angle: 7 * next(), yaw: next() }));
    expect([c[3], c[6], c[7]]).toEqual([c[1], c[2], c[5]]);
    expect(c[0]! * c[4]! - c[1]! * c[1]!).toBeGreaterThan(0);
    expect(c[8]).toBeGreaterThan(0);
  }
});

test('the long axis of 0.3 m along 90 degrees is the variance of y', () => {
  const c = covarianceOf({ major: 0.3, minor: 0.1, angle: Math.PI / 2, yaw: 2 * RAD });
  expect(c[0]).toBeCloseTo(0.01, 12);
  expect(c[4]).toBeCloseTo(0.09, 12);
  expect(c[1]).toBeCloseTo(0, 12);
  expect(c[8]).toBeCloseTo(0.0012184696791468343, 15);
});

test('a circle has no direction, and a shorter axis that grows past the longer one becomes it', () => {
  expect(spreadOf(covarianceOf({ major: 0.1, minor: 0.1, angle: 1, yaw: 0.1 })).angle).toBe(0);
  expect(tidied({ major: 0.1, minor: 0.4, angle: 0, yaw: 0.1 })).toMatchObject({ major: 0.4, minor: 0.1, angle: Math.PI / 2 });
});

test('keeps to what a measurement can have', () => {
  expect(tidied({ major: 0, minor: -1, angle: 0, yaw: 0 })).toMatchObject({ major: SMALLEST_M, minor: SMALLEST_M, yaw: SMALLEST_RAD });
  expect(tidied({ major: 1e9, minor: 1, angle: 0, yaw: 99 })).toMatchObject({ major: 1000, yaw: Math.PI });
});

test('the presets are what their names say', () => {
  expect(spreadText(byHand)).toBe('0.10 m, 2.0°');
  expect(presets.map(({ spread }) => spreadText(spread))).toEqual(['0.10 m, 2.0°', '2.0 cm, 0.5°']);
  expect(spreadText({ major: 0.2, minor: 0.05, angle: 30 * RAD, yaw: RAD })).toBe('0.20 m × 5.0 cm at 30°, 1.0°');
});
