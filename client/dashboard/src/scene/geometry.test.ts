// SPDX-License-Identifier: Apache-2.0
import { expect, test } from 'vitest';
import { affineOf, apply, between, boundsOf, composed, inverted } from './affine';
import { fitted, formatView, panned, parseView, screenToWorld, viewOf, worldToScreen, zoomedAt } from './camera';
import { ellipse95 } from './ellipse';
import { turnOf } from './glyphs';

const size = { width: 800, height: 600 };
const camera = { x: 10, y: -5, scale: 4 };

test('y goes up in the world and down on the screen', () => {
  expect(worldToScreen(camera, size, { x: 10, y: -5 })).toEqual({ x: 400, y: 300 });
  expect(worldToScreen(camera, size, { x: 11, y: -4 })).toEqual({ x: 404, y: 296 });
});

test('screen to world is the inverse', () => {
  const world = screenToWorld(camera, size, { x: 123, y: 456 });
  expect(worldToScreen(camera, size, world)).toEqual({ x: expect.closeTo(123), y: expect.closeTo(456) });
});

test('zooming keeps the point under the pointer', () => {
  const at = { x: 100, y: 50 };
  const before = screenToWorld(camera, size, at);
  const after = screenToWorld(zoomedAt(camera, size, at, 3.7), size, at);
  expect(after.x).toBeCloseTo(before.x, 9);
  expect(after.y).toBeCloseTo(before.y, 9);
});

test('panning moves what is seen with the pointer', () => {
  const moved = panned(camera, 20, 30);
  expect(worldToScreen(moved, size, { x: 10, y: -5 })).toEqual({ x: 420, y: 330 });
});

test('fitting shows all of the bounds, in a tall window, too', () => {
  const bounds = { minX: -50, minY: 0, maxX: 150, maxY: 20 };
  for (const window of [size, { width: 300, height: 900 }]) {
    const view = viewOf(fitted(bounds, window), window);
    expect(view.minX).toBeLessThan(-50);
    expect(view.maxX).toBeGreaterThan(150);
    expect(view.minY).toBeLessThan(0);
    expect(view.maxY).toBeGreaterThan(20);
  }
});

test('a view in an address is read back, and nonsense is refused', () => {
  expect(parseView(formatView({ x: 12.4, y: -3.1, scale: 2.5 }))).toEqual({ x: 12.4, y: -3.1, scale: 2.5 });
  for (const text of [null, '', '1,2', '1,2,3,4', '1,x,3', '1,2,0', '1,2,Infinity', 'NaN,2,3']) expect(parseView(text)).toBeUndefined();
});

test('affines compose as poses do', () => {
  const map = affineOf({ x: 100, y: 50, yaw: Math.PI / 2 });
  const grid = affineOf({ x: 1, y: 2, yaw: 0 }, 0.05);
  expect(apply(composed(map, grid), { x: 20, y: 0 })).toEqual({ x: expect.closeTo(98), y: expect.closeTo(52) });
  const there = apply(composed(map, grid), { x: 7, y: 9 });
  expect(apply(inverted(composed(map, grid)), there)).toEqual({ x: expect.closeTo(7), y: expect.closeTo(9) });
});

test('bounds contain a rotated rectangle', () => {
  const bounds = boundsOf(affineOf({ x: 0, y: 0, yaw: Math.PI / 4 }), 0, 0, 1, 1);
  expect(bounds.minX).toBeCloseTo(-Math.SQRT1_2);
  expect(bounds.maxY).toBeCloseTo(Math.SQRT2);
});

test('turning takes the shorter way', () => {
  expect(between({ x: 0, y: 0, yaw: 3 }, { x: 2, y: 0, yaw: -3 }, 0.5)).toMatchObject({ x: 1, yaw: expect.closeTo(Math.PI) });
});

// Points of the ellipse have the same Mahalanobis distance, that of 95 %.
test('the ellipse is the contour of 95 %', () => {
  let seed = 1;
  const random = () => (seed = (seed * 16807) % 2147483647) / 2147483647;
  for (let i = 0; i < 20; ++i) {
    const [p, q, r] = [random() * 3, random() * 3 - 1.5, random() * 3];
    const [xx, xy, yy] = [p * p + q * q + 0.01, q * r, r * r + 0.01];
    const { major, minor, angle } = ellipse95(xx, xy, yy);
    const det = xx * yy - xy * xy;
    for (const [u, v] of [[major, 0], [0, minor], [major * Math.SQRT1_2, minor * Math.SQRT1_2]] as const) {
      const x = u * Math.cos(angle) - v * Math.sin(angle);
      const y = u * Math.sin(angle) + v * Math.cos(angle);
      expect((yy * x * x - 2 * xy * x * y + xx * y * y) / det).toBeCloseTo(5.9915, 3);
    }
  }
});

test('an ellipse turns with its map, on the page of the map', () => {
  const robots = { placed: [1, 0], map: [0, 0, 0.5, 0, 0, 2], world: [0, 0, 1.2, 0, 0, 0] };
  const frame = (map?: string) => ({ site: { robots }, view: { map } }) as unknown as Parameters<typeof turnOf>[0];
  expect(turnOf(frame('sites/s/maps/m'), 0)).toBeCloseTo(-0.7);
  expect(turnOf(frame('sites/s/maps/m'), 1)).toBe(0); // its covariance is that of its map
  expect(turnOf(frame(), 0)).toBe(0);
});
