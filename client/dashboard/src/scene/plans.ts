// SPDX-License-Identifier: Apache-2.0
// The walls of floor plans, in the world: what robots have seen of them, and what they have not.
import { worldToScreen, type Bounds, type Point } from './camera';
import { addGlyph, shape } from './gl/glyphLayer';
import type { InstanceList } from './gl/program';
import { addLine } from './glyphs';
import type { Frame } from './model';
import { rgba, type Palette } from './palette';

// What robots know of a wall. Added: the plan does not have it; placed: it is where the plan as a whole lies, before its
// walls are moved one by one.
export type WallState = 'seen' | 'unseen' | 'contradicted' | 'added' | 'placed';

export interface PlanLine {
  // Metres of the world.
  from: Point;
  to: Point;
  kind: 'wall' | 'door';
  state: WallState;
}

export interface Plan {
  name: string;
  level: number;
  lines: PlanLine[];
  // Of all lines; undefined: there are none.
  bounds: Bounds | undefined;
  // 0 to 1; left out: 1.
  alpha?: number | undefined;
}

const WALL_PX = 2;
const DOOR_PX = 1;
const DASH_PX = 4;

const states: readonly WallState[] = ['seen', 'unseen', 'contradicted', 'added'];

function pointOf(position: unknown): Point | undefined {
  if (!Array.isArray(position)) return undefined;
  const [x, y] = position as unknown[];
  return typeof x === 'number' && typeof y === 'number' && Number.isFinite(x) && Number.isFinite(y) ? { x, y } : undefined;
}

interface Feature {
  geometry?: { type?: unknown; coordinates?: unknown } | null;
  properties?: { kind?: unknown; state?: unknown } | null;
}

// The walls and doors of a walls.geojson; what is neither is left out. A wall of an unknown state counts as unseen.
export function linesOfPlan(content: unknown): PlanLine[] {
  const features = (content as { features?: unknown } | null)?.features;
  if (!Array.isArray(features)) return [];
  return (features as (Feature | null)[]).flatMap((feature) => {
    const kind = feature?.properties?.kind;
    const { type, coordinates } = feature?.geometry ?? {};
    if ((kind !== 'wall' && kind !== 'door') || type !== 'LineString' || !Array.isArray(coordinates)) return [];
    const state = states.find((one) => one === feature?.properties?.state) ?? 'unseen';
    const points = coordinates.map(pointOf);
    return points.slice(1).flatMap((to, i) => {
      const from = points[i];
      return from && to ? [{ from, to, kind, state }] : [];
    });
  });
}

export function boundsOfLines(lines: PlanLine[]): Bounds | undefined {
  if (lines.length === 0) return undefined;
  const bounds = { minX: Infinity, minY: Infinity, maxX: -Infinity, maxY: -Infinity };
  for (const { x, y } of lines.flatMap(({ from, to }) => [from, to])) {
    bounds.minX = Math.min(bounds.minX, x);
    bounds.minY = Math.min(bounds.minY, y);
    bounds.maxX = Math.max(bounds.maxX, x);
    bounds.maxY = Math.max(bounds.maxY, y);
  }
  return bounds;
}

// Whether anything of a line may be in the window.
export const mayShow = ({ from, to }: PlanLine, { minX, minY, maxX, maxY }: Bounds) =>
  Math.max(from.x, to.x) >= minX && Math.min(from.x, to.x) <= maxX && Math.max(from.y, to.y) >= minY && Math.min(from.y, to.y) <= maxY;

function addDashes(list: InstanceList, { camera, size }: Frame, { from, to }: PlanLine, width: number, colour: number) {
  const [a, b] = [worldToScreen(camera, size, from), worldToScreen(camera, size, to)];
  addGlyph(list, {
    x: (a.x + b.x) / 2 - size.width / 2, y: size.height / 2 - (a.y + b.y) / 2, halfX: Math.hypot(b.x - a.x, b.y - a.y) / 2, halfY: 0,
    angle: Math.atan2(a.y - b.y, b.x - a.x), shape: shape.line, stroke: width, dash: DASH_PX, line: colour, fill: 0,
  });
}

// Those of the level that is shown; all if there is none. Dashed is what robots have looked through.
export function addPlans(list: InstanceList, palette: Palette, frame: Frame) {
  const { plans = [], level } = frame.view;
  const { planSeen, planUnseen, blocked, candidate, select } = palette.colour;
  for (const plan of plans) {
    if (level !== undefined && plan.level !== level) continue;
    const { alpha = 1 } = plan;
    const colours: Record<WallState, number> = {
      seen: rgba(planSeen, alpha), unseen: rgba(planUnseen, alpha), contradicted: rgba(blocked, alpha),
        added: rgba(candidate, alpha), placed: rgba(select, alpha),
    };
    for (const line of plan.lines) {
      if (!mayShow(line, frame.window)) continue;
      const width = line.kind === 'door' ? DOOR_PX : WALL_PX;
      if (line.state === 'contradicted') addDashes(list, frame, line, width, colours.contradicted);
      else addLine(list, frame, line.from, line.to, width, colours[line.state]);
    }
    if (plan.bounds) {
      const { minX, minY, maxX, maxY } = plan.bounds;
      frame.marks.push({ kind: 'plan', name: plan.name, from: worldToScreen(frame.camera, frame.size, { x: minX, y: maxY }), to: worldToScreen(frame.camera, frame.size, { x: maxX, y: minY }) });
    }
  }
}
