// SPDX-License-Identifier: Apache-2.0
// Where the window looks at the world. World: metres, y up. Screen: CSS pixels from the upper left corner, y down. The only
// flip of y is here.

export interface Point {
  x: number;
  y: number;
}

export interface Pose {
  x: number;
  y: number;
  yaw: number;
}

export interface Camera {
  // The world point in the middle of the window.
  x: number;
  y: number;
  // Pixels per metre.
  scale: number;
}

// CSS pixels.
export interface Size {
  width: number;
  height: number;
}

export interface Bounds {
  minX: number;
  minY: number;
  maxX: number;
  maxY: number;
}

export const MIN_SCALE = 0.01;
export const MAX_SCALE = 2000;

export function worldToScreen(camera: Camera, size: Size, world: Point): Point {
  return { x: size.width / 2 + (world.x - camera.x) * camera.scale, y: size.height / 2 - (world.y - camera.y) * camera.scale };
}

export function screenToWorld(camera: Camera, size: Size, screen: Point): Point {
  return { x: camera.x + (screen.x - size.width / 2) / camera.scale, y: camera.y - (screen.y - size.height / 2) / camera.scale };
}

// Keeps the world point under `at` (screen) where it is.
export function zoomedAt(camera: Camera, size: Size, at: Point, factor: number): Camera {
  const scale = Math.min(MAX_SCALE, Math.max(MIN_SCALE, camera.scale * factor));
  const fixed = screenToWorld(camera, size, at);
  const dx = (at.x - size.width / 2) / scale;
  const dy = (at.y - size.height / 2) / scale;
  return { x: fixed.x - dx, y: fixed.y + dy, scale };
}

export function panned(camera: Camera, dx: number, dy: number): Camera {
  return { ...camera, x: camera.x - dx / camera.scale, y: camera.y + dy / camera.scale };
}

// Shows all of `bounds` with a margin. What has no extent, such as one robot, is shown 20 m wide.
export function fitted(bounds: Bounds, size: Size, marginPx = 32): Camera {
  const width = Math.max(bounds.maxX - bounds.minX, 20);
  const height = Math.max(bounds.maxY - bounds.minY, 20);
  const scale = Math.min(Math.max(1, size.width - 2 * marginPx) / width, Math.max(1, size.height - 2 * marginPx) / height);
  return {
    x: (bounds.minX + bounds.maxX) / 2,
    y: (bounds.minY + bounds.maxY) / 2,
    scale: Math.min(MAX_SCALE, Math.max(MIN_SCALE, scale)),
  };
}

export function viewOf(camera: Camera, size: Size): Bounds {
  const halfWidth = size.width / 2 / camera.scale;
  const halfHeight = size.height / 2 / camera.scale;
  return { minX: camera.x - halfWidth, minY: camera.y - halfHeight, maxX: camera.x + halfWidth, maxY: camera.y + halfHeight };
}

// "12.40,-3.10,2.5": x, y, pixels per metre.
export const formatView = ({ x, y, scale }: Camera) => `${x.toFixed(2)},${y.toFixed(2)},${Number(scale.toPrecision(4))}`;

export function parseView(text: string | null): Camera | undefined {
  const [x, y, scale, ...rest] = (text ?? '').split(',').map((part) => (part.trim() === '' ? NaN : Number(part)));
  if (rest.length > 0 || x === undefined || y === undefined || scale === undefined) return undefined;
  if (![x, y, scale].every(Number.isFinite) || scale < MIN_SCALE || scale > MAX_SCALE) return undefined;
  return { x, y, scale };
}
