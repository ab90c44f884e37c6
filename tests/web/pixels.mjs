// SPDX-License-Identifier: Apache-2.0
// What is on the screen, pixel by pixel.
import { PNG } from 'pngjs';

// The canvas without what lies over it: at(x, y) is [red, green, blue] of a CSS pixel of the canvas.
export async function pixelsOf(page) {
  const clip = await page.evaluate(() => {
    for (const over of document.querySelectorAll('.labels, .scene-tools, .scene-status, .hover-card')) over.style.visibility = 'hidden';
    const { x, y, width, height } = document.querySelector('.scene-canvas').getBoundingClientRect();
    return { x, y, width, height };
  });
  const { data, width, height } = PNG.sync.read(await page.screenshot({ clip }));
  return { width, height, at: (x, y) => [...data.subarray(4 * (y * width + x), 4 * (y * width + x) + 3)] };
}

// Looks at a point of the world and waits until all of the picture is there.
export async function look(page, camera) {
  await page.evaluate((to) => window.__scene.setCamera(to), camera);
  await page.waitForFunction(() => window.__scene.settled());
}

// What the page draws, in CSS pixels of the canvas; nothing as long as there is no canvas.
export const sceneOf = (page) =>
  page.evaluate(() => {
    const canvas = document.querySelector('.scene-canvas');
    if (!canvas) return { size: { width: 0, height: 0 }, camera: { x: 0, y: 0, scale: 1 }, drawn: [], marks: [] };
    const { width, height } = canvas.getBoundingClientRect();
    return { size: { width, height }, camera: window.__scene.camera(), drawn: window.__scene.drawn(), marks: window.__scene.marks() };
  });

export const distance = (a, b) => Math.hypot(a.x - b.x, a.y - b.y);

// The same as in the dashboard, written anew: the middle of the canvas is the camera's point, y goes up in the world.
export const toScreen = (camera, { width, height }, { x, y }) => ({ x: width / 2 + (x - camera.x) * camera.scale, y: height / 2 - (y - camera.y) * camera.scale });
export const toWorld = (camera, { width, height }, { x, y }) => ({ x: camera.x + (x - width / 2) / camera.scale, y: camera.y - (y - height / 2) / camera.scale });

// Of a point in the frame of `pose`, and back.
export const placed = ({ x: px = 0, y: py = 0, yaw = 0 }, { x, y }) => ({ x: px + Math.cos(yaw) * x - Math.sin(yaw) * y, y: py + Math.sin(yaw) * x + Math.cos(yaw) * y });
export const seenFrom = ({ x: px = 0, y: py = 0, yaw = 0 }, { x, y }) => placed({ yaw: -yaw }, { x: x - px, y: y - py });
