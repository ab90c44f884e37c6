// SPDX-License-Identifier: Apache-2.0
// How exactly a place is known, as people enter it: standard deviations along two axes and of the direction.
import { wrapped } from '../scene/se2';

export interface Spread {
  // Metres; major >= minor.
  major: number;
  minor: number;
  // Of the major axis, from the x axis of the frame, rad.
  angle: number;
  // Of the direction, rad.
  yaw: number;
}

const RAD = Math.PI / 180;

export const presets: readonly { title: string; spread: Spread }[] = [
  { title: 'By hand: 0.1 m, 2°', spread: { major: 0.1, minor: 0.1, angle: 0, yaw: 2 * RAD } },
  { title: 'Measured: 2 cm, 0.5°', spread: { major: 0.02, minor: 0.02, angle: 0, yaw: 0.5 * RAD } },
];

// What a place that was dragged is taken for, unless somebody says more.
export const byHand: Spread = presets[0]!.spread;

export const SMALLEST_M = 0.0001;
export const LARGEST_M = 1000;
export const SMALLEST_RAD = 0.001 * RAD;
export const LARGEST_RAD = Math.PI;

// The direction of an axis is known up to half a turn: in (-pi / 2, pi / 2].
function axis(angle: number): number {
  const turn = wrapped(angle);
  return turn > Math.PI / 2 ? turn - Math.PI : turn <= -Math.PI / 2 ? turn + Math.PI : turn;
}

// `covariance`: 3x3 of (x, y, yaw). What ties x and y to the yaw is not seen.
export function spreadOf(covariance: readonly number[]): Spread {
  const [xx = 0, xy = 0, , , yy = 0, , , , aa = 0] = covariance;
  const mean = (xx + yy) / 2;
  const half = Math.hypot((xx - yy) / 2, xy);
  return {
    major: Math.sqrt(Math.max(0, mean + half)), minor: Math.sqrt(Math.max(0, mean - half)), angle: half <= 1e-12 * mean ? 0 : axis(0.5 * Math.atan2(2 * xy, xx - yy)),
    yaw: Math.sqrt(Math.max(0, aa)),
  };
}

// The 3x3 covariance of (x, y, yaw), row by row. x and y are not tied to the yaw.
export function covarianceOf({ major, minor, angle, yaw }: Spread): number[] {
  const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
  const [a, b] = [major * major, minor * minor];
  const xy = cos * sin * (a - b);
  return [cos * cos * a + sin * sin * b, xy, 0, xy, sin * sin * a + cos * cos * b, 0, 0, 0, yaw * yaw];
}

const clamped = (value: number, least: number, most: number) => Math.min(most, Math.max(least, value));

// Within what the server takes, the larger axis first.
export function tidied({ major, minor, angle, yaw }: Spread): Spread {
  const [a, b] = [clamped(major, SMALLEST_M, LARGEST_M), clamped(minor, SMALLEST_M, LARGEST_M)];
  const turned = a < b ? angle + Math.PI / 2 : angle;
  return { major: Math.max(a, b), minor: Math.min(a, b), angle: axis(turned), yaw: clamped(yaw, SMALLEST_RAD, LARGEST_RAD) };
}

// "0.10 m x 0.05 m at 30°, 2.0°"
export function spreadText({ major, minor, angle, yaw }: Spread): string {
  const length = (value: number) => (value < 0.1 ? `${(100 * value).toFixed(1)} cm` : `${value.toFixed(2)} m`);
  const place = length(major) === length(minor) ? length(major) : `${length(major)} × ${length(minor)} at ${(angle / RAD).toFixed(0)}°`;
  return `${place}, ${(yaw / RAD).toFixed(1)}°`;
}
