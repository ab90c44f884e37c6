// SPDX-License-Identifier: Apache-2.0
import type { Bounds, Point, Pose } from './camera';

// (x, y) -> (a x + c y + e, b x + d y + f), in double: coordinates of a site may be as large as those of UTM.
export interface Affine {
  a: number;
  b: number;
  c: number;
  d: number;
  e: number;
  f: number;
}

export function affineOf({ x, y, yaw }: Pose, scale = 1): Affine {
  const cos = Math.cos(yaw) * scale;
  const sin = Math.sin(yaw) * scale;
  return { a: cos, b: sin, c: -sin, d: cos, e: x, f: y };
}

// First `n`, then `m`.
export function composed(m: Affine, n: Affine): Affine {
  return {
    a: m.a * n.a + m.c * n.b,
    b: m.b * n.a + m.d * n.b,
    c: m.a * n.c + m.c * n.d,
    d: m.b * n.c + m.d * n.d,
    e: m.a * n.e + m.c * n.f + m.e,
    f: m.b * n.e + m.d * n.f + m.f,
  };
}

export const apply = (m: Affine, { x, y }: Point): Point => ({ x: m.a * x + m.c * y + m.e, y: m.b * x + m.d * y + m.f });

export function inverted(m: Affine): Affine {
  const det = m.a * m.d - m.b * m.c;
  const a = m.d / det;
  const b = -m.b / det;
  const c = -m.c / det;
  const d = m.a / det;
  return { a, b, c, d, e: -(a * m.e + c * m.f), f: -(b * m.e + d * m.f) };
}

// Around the image of the rectangle.
export function boundsOf(m: Affine, x0: number, y0: number, x1: number, y1: number): Bounds {
  const corners = [apply(m, { x: x0, y: y0 }), apply(m, { x: x1, y: y0 }), apply(m, { x: x1, y: y1 }), apply(m, { x: x0, y: y1 })];
  return {
    minX: Math.min(...corners.map(({ x }) => x)),
    minY: Math.min(...corners.map(({ y }) => y)),
    maxX: Math.max(...corners.map(({ x }) => x)),
    maxY: Math.max(...corners.map(({ y }) => y)),
  };
}

export const overlap = (a: Bounds, b: Bounds) => a.minX <= b.maxX && b.minX <= a.maxX && a.minY <= b.maxY && b.minY <= a.maxY;

export function united(a: Bounds | undefined, b: Bounds): Bounds {
  if (!a) return b;
  return { minX: Math.min(a.minX, b.minX), minY: Math.min(a.minY, b.minY), maxX: Math.max(a.maxX, b.maxX), maxY: Math.max(a.maxY, b.maxY) };
}

// The shorter way around.
export function between(from: Pose, to: Pose, t: number): Pose {
  const turn = Math.atan2(Math.sin(to.yaw - from.yaw), Math.cos(to.yaw - from.yaw));
  return { x: from.x + (to.x - from.x) * t, y: from.y + (to.y - from.y) * t, yaw: from.yaw + turn * t };
}
