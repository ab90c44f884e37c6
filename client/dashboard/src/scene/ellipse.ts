// SPDX-License-Identifier: Apache-2.0

// chi-squared with 2 degrees of freedom at 95 %.
const CHI2_95 = 5.991464547107979;

export interface Ellipse {
  // Half axes, m; major >= minor.
  major: number;
  minor: number;
  // Of the major axis, rad.
  angle: number;
}

// The ellipse that contains 95 % of a normal distribution with the covariance [xx, xy; xy, yy].
export function ellipse95(xx: number, xy: number, yy: number): Ellipse {
  const mean = (xx + yy) / 2;
  const spread = Math.hypot((xx - yy) / 2, xy);
  return {
    major: Math.sqrt(CHI2_95 * Math.max(0, mean + spread)),
    minor: Math.sqrt(CHI2_95 * Math.max(0, mean - spread)),
    angle: 0.5 * Math.atan2(2 * xy, xx - yy),
  };
}
