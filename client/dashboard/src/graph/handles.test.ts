// SPDX-License-Identifier: Apache-2.0
import { expect, test } from 'vitest';
import { draggedTo, gripsOf, HEADING_PX, steppedBy, WEDGE_PX } from './handles';

const camera = { x: 0, y: 0, scale: 50 };
const size = { width: 800, height: 600 };
const pose = { x: 1, y: 2, yaw: 0.3 };
const spread = { major: 0.8, minor: 0.4, angle: 0.2, yaw: 0.4 };
const frame = { x: 3, y: -1, yaw: 1.1 };
const begin = { pose, spread };
const grips = gripsOf(pose, spread, frame, camera, size);

test('where nothing has been dragged, nothing changes', () => {
  for (const handle of ['middle', 'heading', 'major', 'minor'] as const) {
    const { pose: to, spread: wide } = draggedTo(handle, grips[handle], begin, grips, frame, camera.scale);
    expect(to.x).toBeCloseTo(pose.x, 9);
    expect(to.y).toBeCloseTo(pose.y, 9);
    expect(to.yaw).toBeCloseTo(pose.yaw, 9);
    for (const key of ['major', 'minor', 'yaw'] as const) expect(wide[key]).toBeCloseTo(spread[key], 9);
    expect(Math.cos(2 * (wide.angle - spread.angle))).toBeCloseTo(1, 9);
  }
  expect(draggedTo('wedge', grips.wedge[0], begin, grips, frame, camera.scale).spread.yaw).toBeCloseTo(spread.yaw, 9);
});

test('a pixel to the right is a fiftieth of a metre of the world, in the frame of the map', () => {
  const at = { x: grips.middle.x + 50, y: grips.middle.y };
  const { pose: to } = draggedTo('middle', at, begin, grips, frame, camera.scale);
  expect(to.x).toBeCloseTo(pose.x + Math.cos(frame.yaw), 9);
  expect(to.y).toBeCloseTo(pose.y - Math.sin(frame.yaw), 9);
});

test('an axis is pulled to its length and direction, also when it is drawn larger than it is', () => {
  const small = { ...spread, major: 0.01, minor: 0.005 };
  const drawn = gripsOf(pose, small, frame, camera, size);
  expect(drawn.isEnlarged).toBe(true);
  const twice = { x: drawn.middle.x + 2 * (drawn.major.x - drawn.middle.x), y: drawn.middle.y + 2 * (drawn.major.y - drawn.middle.y) };
  expect(draggedTo('major', twice, { pose, spread: small }, drawn, frame, camera.scale).spread.major).toBeCloseTo(0.02, 9);
  const up = { x: grips.middle.x, y: grips.middle.y - grips.majorPx };
  expect(Math.cos(2 * (draggedTo('major', up, begin, grips, frame, camera.scale).spread.angle + frame.yaw - Math.PI / 2))).toBeCloseTo(1, 9);
});

test('the handles lie apart enough to be grabbed', () => {
  const narrow = gripsOf(pose, { major: 0.001, minor: 0.001, angle: pose.yaw, yaw: 0.0001 }, frame, camera, size);
  const places = [narrow.middle, narrow.heading, narrow.major, narrow.minor, narrow.wedge[0]];
  for (const [i, a] of places.entries()) for (const b of places.slice(i + 1)) expect(Math.hypot(a.x - b.x, a.y - b.y)).toBeGreaterThan(18);
  expect(WEDGE_PX - HEADING_PX).toBeGreaterThan(24);
});

test('arrow keys do the same, by steps that shift makes fine', () => {
  const straight = { x: 0, y: 0, yaw: 0 };
  expect(steppedBy('middle', 'ArrowRight', false, begin, straight)?.pose.x).toBeCloseTo(1.05, 12);
  expect(steppedBy('middle', 'ArrowDown', true, begin, straight)?.pose.y).toBeCloseTo(1.995, 12);
  expect(steppedBy('heading', 'ArrowLeft', false, begin, straight)?.pose.yaw).toBeCloseTo(0.3 + Math.PI / 180, 12);
  expect(steppedBy('major', 'ArrowRight', false, begin, straight)?.spread.major).toBeCloseTo(0.88, 12);
  expect(steppedBy('wedge', 'ArrowDown', false, begin, straight)?.spread.yaw).toBeCloseTo(0.4 / 1.1, 12);
  expect(steppedBy('middle', 'Enter', false, begin, straight)).toBeUndefined();
});
