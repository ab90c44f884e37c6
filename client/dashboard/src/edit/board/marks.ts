// SPDX-License-Identifier: Apache-2.0
// Lines over the cells: what is being drawn, where others are, what the page points at.
import { rgba, type Rgb } from '../../scene/palette';
import type { Box } from '../lattice';
import type { Sketch } from '../tools/pens';

export interface MarkColours {
  grid: string;
  line: string;
  halo: string;
  other: string;
  area: string;
}

export const css = ([r, g, b]: Rgb) => `#${(rgba([b, g, r], 0) & 0xffffff).toString(16).padStart(6, '0')}`;

// An outline with a name, in cells.
export interface Outline {
  name: string;
  corners: { x: number; y: number }[];
  isSelected: boolean;
}

// To pixels of the device.
export type Project = (x: number, y: number) => [x: number, y: number];

function path(context: CanvasRenderingContext2D, points: [number, number][], isClosed: boolean) {
  context.beginPath();
  points.forEach(([x, y], i) => (i === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
  if (isClosed) context.closePath();
}

// Over a halo, so that it is seen on any cells.
function stroke(context: CanvasRenderingContext2D, colours: MarkColours, colour: string, width: number) {
  context.strokeStyle = colours.halo;
  context.lineWidth = width + 2;
  context.stroke();
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.stroke();
}

function label(context: CanvasRenderingContext2D, colours: MarkColours, colour: string, text: string, x: number, y: number, ratio: number) {
  context.font = `${12 * ratio}px system-ui, sans-serif`;
  context.lineWidth = 3 * ratio;
  context.strokeStyle = colours.halo;
  context.strokeText(text, x, y);
  context.fillStyle = colour;
  context.fillText(text, x, y);
}

export function drawSketch(context: CanvasRenderingContext2D, colours: MarkColours, project: Project, { points, isClosed }: Sketch, ratio: number) {
  const at = points.map(({ x, y }) => project(x / 256, y / 256));
  path(context, at, isClosed);
  stroke(context, colours, colours.line, 1.5 * ratio);
  for (const [x, y] of at) {
    context.beginPath();
    context.arc(x, y, 3 * ratio, 0, 2 * Math.PI);
    stroke(context, colours, colours.line, 1.5 * ratio);
  }
}

export function drawRing(context: CanvasRenderingContext2D, colours: MarkColours, [x, y]: [number, number], radius: number, ratio: number) {
  context.beginPath();
  context.arc(x, y, Math.max(2 * ratio, radius), 0, 2 * Math.PI);
  stroke(context, colours, colours.line, ratio);
}

export function drawBox(context: CanvasRenderingContext2D, colours: MarkColours, project: Project, box: Box, colour: string, ratio: number) {
  const [x0, y0] = project(box.firstColumn, box.firstRow);
  const [x1, y1] = project(box.firstColumn + box.width, box.firstRow + box.height);
  path(context, [[x0, y0], [x1, y0], [x1, y1], [x0, y1]], true);
  stroke(context, colours, colour, 1.5 * ratio);
}

export function drawOutline(context: CanvasRenderingContext2D, colours: MarkColours, project: Project, { corners, name, isSelected }: Outline, ratio: number) {
  const at = corners.map(({ x, y }) => project(x, y));
  path(context, at, true);
  context.setLineDash(isSelected ? [] : [6 * ratio, 4 * ratio]);
  stroke(context, colours, colours.area, (isSelected ? 2.5 : 1.5) * ratio);
  context.setLineDash([]);
  const top = at.reduce((best, point) => (point[1] < best[1] ? point : best), at[0] ?? [0, 0]);
  label(context, colours, colours.area, name, top[0] + 4 * ratio, top[1] - 6 * ratio, ratio);
}

export function drawPointer(context: CanvasRenderingContext2D, colours: MarkColours, [x, y]: [number, number], name: string, ratio: number) {
  path(context, [[x, y], [x, y + 14 * ratio], [x + 4 * ratio, y + 10 * ratio], [x + 10 * ratio, y + 10 * ratio]], true);
  context.fillStyle = colours.other;
  stroke(context, colours, colours.other, ratio);
  context.fill();
  label(context, colours, colours.other, name, x + 12 * ratio, y + 22 * ratio, ratio);
}

// The borders of cells, where these are large enough.
export function drawGrid(context: CanvasRenderingContext2D, colours: MarkColours, project: Project, x0: number, y0: number, x1: number, y1: number, ratio: number) {
  context.beginPath();
  for (let x = Math.floor(x0); x <= x1; ++x) {
    const [at, from] = project(x, y0);
    context.moveTo(Math.round(at), from);
    context.lineTo(Math.round(at), project(x, y1)[1]);
  }
  for (let y = Math.floor(y0); y <= y1; ++y) {
    const [from, at] = project(x0, y);
    context.moveTo(from, Math.round(at));
    context.lineTo(project(x1, y)[0], Math.round(at));
  }
  context.strokeStyle = colours.grid;
  context.lineWidth = 0.5 * ratio;
  context.stroke();
}
