// SPDX-License-Identifier: Apache-2.0
// 3x3 matrices, row by row, as the API has covariances of (x, y, yaw).

export type Matrix3 = readonly number[];

export function product(a: Matrix3, b: Matrix3): number[] {
  const out = new Array<number>(9).fill(0);
  for (let row = 0; row < 3; ++row) for (let column = 0; column < 3; ++column) for (let k = 0; k < 3; ++k) out[3 * row + column]! += a[3 * row + k]! * b[3 * k + column]!;
  return out;
}

export const transposed = (a: Matrix3): number[] => [0, 3, 6, 1, 4, 7, 2, 5, 8].map((i) => a[i]!);

// J S J'. Symmetric to the last bit, as the API demands.
export function carried(jacobian: Matrix3, covariance: Matrix3): number[] {
  const out = product(product(jacobian, covariance), transposed(jacobian));
  for (const [i, j] of [[1, 3], [2, 6], [5, 7]] as const) out[i] = out[j] = (out[i]! + out[j]!) / 2;
  return out;
}

export const scaled = (a: Matrix3, factor: number): number[] => a.map((value) => value * factor);

export const sum = (a: Matrix3, b: Matrix3): number[] => a.map((value, i) => value + b[i]!);
