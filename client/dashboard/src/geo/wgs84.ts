// SPDX-License-Identifier: Apache-2.0
// Places on the ellipsoid of WGS84, and the plane that touches it at one of them: metres to the east and to the north.
// Within a few kilometres it agrees with the server's transverse Mercator projection (core/geo) to less than a millimetre.
import type { Point } from '../scene/camera';

// Degrees.
export interface LatLon {
  latitude: number;
  longitude: number;
}

type Vector = [x: number, y: number, z: number];

const A = 6_378_137;
const F = 1 / 298.257223563;
const E2 = F * (2 - F);
const RAD = Math.PI / 180;

// Earth-centred, m.
function geocentric({ latitude, longitude }: LatLon): Vector {
  const [sin, cos] = [Math.sin(latitude * RAD), Math.cos(latitude * RAD)];
  const n = A / Math.sqrt(1 - E2 * sin * sin);
  return [n * cos * Math.cos(longitude * RAD), n * cos * Math.sin(longitude * RAD), n * (1 - E2) * sin];
}

// Bowring (1976), exact enough beside the ellipsoid without iterating.
function geodetic([x, y, z]: Vector): LatLon {
  const p = Math.hypot(x, y);
  const beta = Math.atan2(z, (1 - F) * p);
  const second = E2 / (1 - E2);
  const latitude = Math.atan2(z + second * A * (1 - F) * Math.sin(beta) ** 3, p - E2 * A * Math.cos(beta) ** 3);
  return { latitude: latitude / RAD, longitude: Math.atan2(y, x) / RAD };
}

// The directions of east, north and up.
function axesAt({ latitude, longitude }: LatLon): [Vector, Vector, Vector] {
  const [sinP, cosP, sinL, cosL] = [Math.sin(latitude * RAD), Math.cos(latitude * RAD), Math.sin(longitude * RAD), Math.cos(longitude * RAD)];
  return [[-sinL, cosL, 0], [-sinP * cosL, -sinP * sinL, cosP], [cosP * cosL, cosP * sinL, sinP]];
}

const dot = (a: Vector, b: Vector) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

// Metres east (x) and north (y) of `origin`.
export function toPlane(origin: LatLon, place: LatLon): Point {
  const [from, to] = [geocentric(origin), geocentric(place)];
  const [east, north] = axesAt(origin);
  const way: Vector = [to[0] - from[0], to[1] - from[1], to[2] - from[2]];
  return { x: dot(way, east), y: dot(way, north) };
}

export function fromPlane(origin: LatLon, { x, y }: Point): LatLon {
  const from = geocentric(origin);
  const [east, north, up] = axesAt(origin);
  const down = -(x * x + y * y) / (2 * A); // the plane leaves the ground
  return geodetic([0, 1, 2].map((i) => from[i]! + x * east[i]! + y * north[i]! + down * up[i]!) as Vector);
}
