// SPDX-License-Identifier: Apache-2.0
import { expect, test } from 'vitest';
import { pose } from './format';

test('a direction is within half a turn, however often the robot has turned', () => {
  expect(pose({ x: 1, y: -2, yaw: Math.PI / 2 + 2e6 * Math.PI })).toBe('1.00, -2.00 m, 90.0°');
  expect(pose({ x: 0, y: 0, yaw: -3.5 * Math.PI })).toBe('0.00, 0.00 m, 90.0°');
  expect(pose({ x: 0, y: 0, yaw: -0.0001 })).toBe('0.00, 0.00 m, 0.0°');
});
