// SPDX-License-Identifier: Apache-2.0
// The outlines of a map's areas, in the frame that is shown.
import { worldToScreen, type Bounds, type Point } from './camera';
import type { InstanceList } from './gl/program';
import { addLine } from './glyphs';
import type { Frame } from './model';
import { rgba, type Palette } from './palette';

// What people tell apart by colour: where robots may not go, where they slow down, and all else.
export type AreaTone = 'closed' | 'slow' | 'other';

export interface Area {
  name: string;
  tone: AreaTone;
  corners: Point[];
}

const AREA_PX = 1.5;

export function boundsOfCorners(corners: Point[]): Bounds {
  const x = corners.map((corner) => corner.x);
  const y = corners.map((corner) => corner.y);
  return { minX: Math.min(...x), minY: Math.min(...y), maxX: Math.max(...x), maxY: Math.max(...y) };
}

const overlap = (a: Bounds, b: Bounds) => a.minX <= b.maxX && a.maxX >= b.minX && a.minY <= b.maxY && a.maxY >= b.minY;

export function addAreas(list: InstanceList, palette: Palette, frame: Frame) {
  const colours: Record<AreaTone, number> = {
    closed: rgba(palette.colour.blocked), slow: rgba(palette.colour.candidate), other: rgba(palette.colour.planUnseen),
  };
  for (const { name, tone, corners } of frame.view.areas ?? []) {
    if (corners.length < 3) continue;
    const bounds = boundsOfCorners(corners);
    if (!overlap(bounds, frame.window)) continue;
    corners.forEach((from, i) => addLine(list, frame, from, corners[(i + 1) % corners.length]!, AREA_PX, colours[tone]));
    const { minX, minY, maxX, maxY } = bounds;
    frame.marks.push({ kind: 'area', name, from: worldToScreen(frame.camera, frame.size, { x: minX, y: maxY }), to: worldToScreen(frame.camera, frame.size, { x: maxX, y: minY }) });
  }
}
