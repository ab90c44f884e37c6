// SPDX-License-Identifier: Apache-2.0
// What a person grabs of an anchor, in CSS pixels of the canvas: its middle, its heading, the ends of its ellipse's axes and
// of its wedge. What is too small to be grabbed is drawn larger; dragging it then scales it by what it was.
import { worldToScreen, type Camera, type Point, type Pose, type Size } from '../scene/camera';
import { chained, wrapped } from '../scene/se2';
import { LARGEST_RAD, tidied, type Spread } from './spread';

// The quantiles of a 95 % ellipse, and of a 95 % interval.
export const ELLIPSE_95 = Math.sqrt(5.991464547107979);
export const INTERVAL_95 = 1.959963984540054;

export const HEADING_PX = 64;
// Farther out, so that a narrow wedge's handle does not lie on that of the heading.
export const WEDGE_PX = 92;
const LEAST_MAJOR_PX = 30;
const LEAST_MINOR_PX = 20;
const LEAST_WEDGE = 0.12;
const MOST_WEDGE = 3;

export type Handle = 'middle' | 'heading' | 'major' | 'minor' | 'wedge';

export interface Grips {
  middle: Point;
  heading: Point;
  major: Point;
  minor: Point;
  // The two ends of the wedge's arc; the first one is a handle.
  wedge: [Point, Point];
  // Of the ellipse as it is drawn, px; `angle` counter-clockwise on the screen.
  majorPx: number;
  minorPx: number;
  angle: number;
  // Directions counter-clockwise on the screen, rad.
  yaw: number;
  halfWedge: number;
  // Drawn larger than it is.
  isEnlarged: boolean;
}

const toward = ({ x, y }: Point, angle: number, length: number): Point => ({ x: x + length * Math.cos(angle), y: y - length * Math.sin(angle) });

// `pose`: of the anchor in its map, `frame`: of that map in what is shown.
export function gripsOf(pose: Pose, spread: Spread, frame: Pose, camera: Camera, size: Size): Grips {
  const place = chained(frame, pose);
  const middle = worldToScreen(camera, size, place);
  const [major, minor] = [spread.major * ELLIPSE_95 * camera.scale, spread.minor * ELLIPSE_95 * camera.scale];
  const [majorPx, minorPx] = [Math.max(LEAST_MAJOR_PX, major), Math.max(LEAST_MINOR_PX, minor)];
  const angle = frame.yaw + spread.angle;
  const halfWedge = Math.min(MOST_WEDGE, Math.max(LEAST_WEDGE, spread.yaw * INTERVAL_95));
  return {
    middle, heading: toward(middle, place.yaw, HEADING_PX), major: toward(middle, angle, majorPx), minor: toward(middle, angle + Math.PI / 2, minorPx),
    wedge: [toward(middle, place.yaw + halfWedge, WEDGE_PX), toward(middle, place.yaw - halfWedge, WEDGE_PX)],
    majorPx, minorPx, angle, yaw: place.yaw, halfWedge, isEnlarged: major < majorPx || minor < minorPx,
  };
}

// The direction of `at` as seen from `from`, counter-clockwise on the screen.
const directionTo = (from: Point, at: Point) => Math.atan2(from.y - at.y, at.x - from.x);
const distanceTo = (from: Point, at: Point) => Math.hypot(at.x - from.x, at.y - from.y);

export interface Grabbed {
  pose: Pose;
  spread: Spread;
}

// What the anchor is when `handle` has been dragged to `at`. `begin`: what was grabbed, `grips`: where it was then.
export function draggedTo(handle: Handle, at: Point, begin: Grabbed, grips: Grips, frame: Pose, scale: number): Grabbed {
  const { pose, spread } = begin;
  const { middle } = grips;
  if (handle === 'middle') {
    const [dx, dy] = [(at.x - middle.x) / scale, -(at.y - middle.y) / scale];
    const [cos, sin] = [Math.cos(frame.yaw), Math.sin(frame.yaw)];
    return { pose: { ...pose, x: pose.x + cos * dx + sin * dy, y: pose.y - sin * dx + cos * dy }, spread };
  }
  const direction = directionTo(middle, at);
  if (handle === 'heading') return { pose: { ...pose, yaw: wrapped(direction - frame.yaw) }, spread };
  if (handle === 'wedge') {
    const half = Math.abs(wrapped(direction - grips.yaw));
    return { pose, spread: { ...spread, yaw: Math.min(LARGEST_RAD, (spread.yaw * half) / grips.halfWedge) } };
  }
  const length = distanceTo(middle, at);
  if (handle === 'major') return { pose, spread: { ...spread, major: (spread.major * length) / grips.majorPx, angle: direction - frame.yaw } };
  return { pose, spread: { ...spread, minor: (spread.minor * length) / grips.minorPx, angle: direction - frame.yaw - Math.PI / 2 } };
}

const STEP_M = 0.05;
const STEP_RAD = Math.PI / 180;
const GROWTH = 1.1;

// The same by an arrow key; `fine`: a tenth of a step. Undefined: the key does nothing here.
export function steppedBy(handle: Handle, key: string, fine: boolean, { pose, spread }: Grabbed, frame: Pose): Grabbed | undefined {
  const across = { ArrowLeft: -1, ArrowRight: 1 }[key] ?? 0;
  const up = { ArrowDown: -1, ArrowUp: 1 }[key] ?? 0;
  if (across === 0 && up === 0) return undefined;
  const share = fine ? 0.1 : 1;
  if (handle === 'middle') {
    const [dx, dy] = [across * STEP_M * share, up * STEP_M * share];
    const [cos, sin] = [Math.cos(frame.yaw), Math.sin(frame.yaw)];
    return { pose: { ...pose, x: pose.x + cos * dx + sin * dy, y: pose.y - sin * dx + cos * dy }, spread };
  }
  // Left is counter-clockwise, as the sign of a yaw.
  const turn = (up - across) * STEP_RAD * share;
  if (handle === 'heading') return { pose: { ...pose, yaw: wrapped(pose.yaw + turn) }, spread };
  const growth = GROWTH ** ((across + up) * share);
  if (handle === 'wedge') return { pose, spread: tidied({ ...spread, yaw: spread.yaw * growth }) };
  if (up !== 0) return { pose, spread: tidied({ ...spread, angle: spread.angle + up * 5 * STEP_RAD * share }) };
  return { pose, spread: tidied({ ...spread, [handle]: spread[handle] * growth }) };
}
