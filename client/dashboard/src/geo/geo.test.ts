// SPDX-License-Identifier: Apache-2.0
import { expect, test } from 'vitest';
import { toLatLon } from './georeference';
import { fromPlane, toPlane } from './wgs84';

test('a degree of latitude and of longitude are as long as on the ellipsoid', () => {
  // At 45 degrees: 111,131.8 m and 78,846.8 m a degree (radii of curvature of WGS84).
  const origin = { latitude: 45, longitude: 7 };
  expect(toPlane(origin, { latitude: 45.001, longitude: 7 }).y).toBeCloseTo(111.1318, 3);
  expect(toPlane(origin, { latitude: 45, longitude: 7.001 }).x).toBeCloseTo(78.8468, 3);
});

test('comes back to the same place, also in the south, in the west and across the antimeridian', () => {
  for (const origin of [{ latitude: 50.77, longitude: 6.08 }, { latitude: -33.9, longitude: -70.6 }, { latitude: 0, longitude: 180 }]) {
    for (const point of [{ x: 0, y: 0 }, { x: 1500, y: -800 }, { x: -40, y: 2000 }]) {
      const there = toPlane(origin, fromPlane(origin, point));
      expect(Math.hypot(there.x - point.x, there.y - point.y)).toBeLessThan(0.001);
    }
  }
});

test('places the world by its control points and its direction', () => {
  const origin = { latitude: 50, longitude: 8 };
  // The world's x axis points north.
  const place = (x: number, y: number) => fromPlane(origin, { x: -y, y: x });
  const controls = [{ x: 0, y: 0 }, { x: 100, y: 0 }, { x: 0, y: 50 }].map((world) => ({ world, place: place(world.x, world.y) }));
  const found = toLatLon(controls, Math.PI / 2)({ x: 30, y: -20 });
  const away = toPlane(place(30, -20), found);
  expect(Math.hypot(away.x, away.y)).toBeLessThan(0.001);
});
