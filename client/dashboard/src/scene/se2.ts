// SPDX-License-Identifier: Apache-2.0
// Poses as transforms: `chained(T_a_b, T_b_c)` is T_a_c.
import type { Point, Pose } from './camera';

// Into [-pi, pi].
export const wrapped = (angle: number) => Math.atan2(Math.sin(angle), Math.cos(angle));

export function placedBy({ x, y, yaw }: Pose, point: Point): Point {
  const [cos, sin] = [Math.cos(yaw), Math.sin(yaw)];
  return { x: x + cos * point.x - sin * point.y, y: y + sin * point.x + cos * point.y };
}

export const chained = (a: Pose, b: Pose): Pose => ({ ...placedBy(a, b), yaw: wrapped(a.yaw + b.yaw) });

export function reversed({ x, y, yaw }: Pose): Pose {
  const [cos, sin] = [Math.cos(yaw), Math.sin(yaw)];
  return { x: -cos * x - sin * y, y: sin * x - cos * y, yaw: wrapped(-yaw) };
}

// T_a_b of two poses in one frame.
export const relative = (a: Pose, b: Pose): Pose => chained(reversed(a), b);

export const samePose = (a: Pose, b: Pose, epsilon = 0) =>
  Math.abs(a.x - b.x) <= epsilon && Math.abs(a.y - b.y) <= epsilon && Math.abs(wrapped(a.yaw - b.yaw)) <= epsilon;
