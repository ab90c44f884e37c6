// SPDX-License-Identifier: Apache-2.0
// The walls and doors of a plan in the sheet frame, and how a person changes them. Nothing here changes a graph: each step
// makes another one.
import type { Point } from '../../../scene/camera';

export interface Wall {
  from: Point;
  to: Point;
  // Units of the sheet; 0: unknown.
  thickness: number;
  confidence: number;
}

export interface Door {
  from: Point;
  to: Point;
  confidence: number;
}

export interface Graph {
  walls: readonly Wall[];
  doors: readonly Door[];
  // Features of rooms and shafts, as they came.
  outlines: readonly unknown[];
  // Undefined: unknown.
  metresPerUnit: number | undefined;
}

export type Element = { kind: 'wall'; index: number } | { kind: 'door'; index: number } | { kind: 'corner'; at: Point };

interface Feature {
  geometry?: { type?: unknown; coordinates?: unknown } | null;
  properties?: { kind?: unknown; thickness?: unknown; confidence?: unknown } | null;
}

const numberOf = (value: unknown, otherwise: number) => (typeof value === 'number' && Number.isFinite(value) ? value : otherwise);

function lineOf(feature: Feature): [Point, Point] | undefined {
  const { type, coordinates } = feature.geometry ?? {};
  if (type !== 'LineString' || !Array.isArray(coordinates) || coordinates.length !== 2) return undefined;
  const [from, to] = (coordinates as unknown[]).map((position) => {
    const [x, y] = Array.isArray(position) ? (position as unknown[]) : [];
    return typeof x === 'number' && typeof y === 'number' ? { x, y } : undefined;
  });
  return from && to ? [from, to] : undefined;
}

// Of a plan.geojson.
export function graphOf(content: unknown): Graph {
  const { features, metres_per_unit: scale } = (content ?? {}) as { features?: unknown; metres_per_unit?: unknown };
  const walls: Wall[] = [];
  const doors: Door[] = [];
  const outlines: unknown[] = [];
  for (const feature of Array.isArray(features) ? (features as (Feature | null)[]) : []) {
    const { kind, thickness, confidence } = feature?.properties ?? {};
    if (kind === 'room' || kind === 'shaft') outlines.push(feature);
    const line = feature && lineOf(feature);
    if (!line) continue;
    const [from, to] = line;
    if (kind === 'wall') walls.push({ from, to, thickness: numberOf(thickness, 0), confidence: numberOf(confidence, 1) });
    else if (kind === 'door') doors.push({ from, to, confidence: numberOf(confidence, 1) });
  }
  return { walls, doors, outlines, metresPerUnit: typeof scale === 'number' && scale > 0 ? scale : undefined };
}

// What EditPriorMap takes.
export function toGeoJson({ walls, doors, outlines, metresPerUnit }: Graph): string {
  const line = (kind: string, { from, to }: { from: Point; to: Point }, properties: object) =>
    ({ type: 'Feature', properties: { kind, ...properties }, geometry: { type: 'LineString', coordinates: [[from.x, from.y], [to.x, to.y]] } });
  return JSON.stringify({
    type: 'FeatureCollection', frame: 'sheet', ...(metresPerUnit === undefined ? {} : { metres_per_unit: metresPerUnit }),
    features: [
      ...walls.map((wall) => line('wall', wall, { thickness: wall.thickness, confidence: wall.confidence })),
      ...doors.map((door) => line('door', door, { confidence: door.confidence })),
      ...outlines,
    ],
  });
}

export const isSame = (a: Point, b: Point) => a.x === b.x && a.y === b.y;

export const lengthOf = ({ from, to }: { from: Point; to: Point }) => Math.hypot(to.x - from.x, to.y - from.y);

const keyOf = ({ x, y }: Point) => `${x} ${y}`;

// Where walls end, each once.
export const cornersOf = ({ walls }: Graph): Point[] => [...new Map(walls.flatMap(({ from, to }) => [from, to]).map((p) => [keyOf(p), p])).values()];

export const wallsAt = ({ walls }: Graph, at: Point): Wall[] => walls.filter(({ from, to }) => isSame(from, at) || isSame(to, at));

// Of all lines; undefined: there are none.
export function boundsOf({ walls, doors }: Graph) {
  const points = [...walls, ...doors].flatMap(({ from, to }) => [from, to]);
  if (points.length === 0) return undefined;
  const bounds = { minX: Infinity, minY: Infinity, maxX: -Infinity, maxY: -Infinity };
  for (const { x, y } of points) {
    bounds.minX = Math.min(bounds.minX, x);
    bounds.minY = Math.min(bounds.minY, y);
    bounds.maxX = Math.max(bounds.maxX, x);
    bounds.maxY = Math.max(bounds.maxY, y);
  }
  return bounds;
}

// Walls of no length are none, and two between the same corners are one.
function tidied(walls: Wall[]): Wall[] {
  const known = new Set<string>();
  return walls.filter((wall) => {
    const ends = [keyOf(wall.from), keyOf(wall.to)].sort().join(' ');
    if (isSame(wall.from, wall.to) || known.has(ends)) return false;
    known.add(ends);
    return true;
  });
}

// The thickness that most walls have.
export function usualThickness({ walls }: Graph): number {
  const sorted = walls.map(({ thickness }) => thickness).sort((a, b) => a - b);
  return sorted[Math.floor(sorted.length / 2)] ?? 0;
}

export const withWall = (graph: Graph, from: Point, to: Point): Graph =>
  ({ ...graph, walls: tidied([...graph.walls, { from, to, thickness: usualThickness(graph), confidence: 1 }]) });

export const withDoor = (graph: Graph, from: Point, to: Point): Graph =>
  isSame(from, to) ? graph : { ...graph, doors: [...graph.doors, { from, to, confidence: 1 }] };

export const withThickness = (graph: Graph, index: number, thickness: number): Graph =>
  ({ ...graph, walls: graph.walls.map((wall, i) => (i === index ? { ...wall, thickness, confidence: 1 } : wall)) });

export const withMeasure = (graph: Graph, from: Point, to: Point, metres: number): Graph => ({ ...graph, metresPerUnit: metres / lengthOf({ from, to }) });

// Walls and doors that end there go along.
export function withCornerMoved(graph: Graph, at: Point, to: Point): Graph {
  const moved = (p: Point) => (isSame(p, at) ? to : p);
  const ends = <T extends { from: Point; to: Point }>(line: T): T => ({ ...line, from: moved(line.from), to: moved(line.to) });
  return { ...graph, walls: tidied(graph.walls.map(ends)), doors: graph.doors.map(ends).filter(({ from, to: end }) => !isSame(from, end)) };
}

// A corner where more than two walls meet cannot be taken away.
export const mayRemove = (graph: Graph, element: Element) => element.kind !== 'corner' || wallsAt(graph, element.at).length <= 2;

// Without a wall or a door; without a corner two walls become one, and a wall that ends there goes.
export function without(graph: Graph, element: Element): Graph {
  if (element.kind === 'door') return { ...graph, doors: graph.doors.filter((_, i) => i !== element.index) };
  if (element.kind === 'wall') return { ...graph, walls: graph.walls.filter((_, i) => i !== element.index) };
  const [one, other, ...more] = wallsAt(graph, element.at);
  if (!one || more.length > 0) return graph;
  const rest = graph.walls.filter((wall) => wall !== one && wall !== other);
  if (!other) return { ...graph, walls: rest };
  const far = ({ from, to }: Wall) => (isSame(from, element.at) ? to : from);
  return { ...graph, walls: tidied([...rest, { ...one, from: far(one), to: far(other) }]) };
}

function nearestOn({ from, to }: { from: Point; to: Point }, p: Point): Point {
  const [dx, dy] = [to.x - from.x, to.y - from.y];
  const square = dx * dx + dy * dy;
  const share = square > 0 ? Math.min(1, Math.max(0, ((p.x - from.x) * dx + (p.y - from.y) * dy) / square)) : 0;
  return { x: from.x + share * dx, y: from.y + share * dy };
}

const distance = (a: Point, b: Point) => Math.hypot(a.x - b.x, a.y - b.y);

function nearest<T>(candidates: T[], far: (candidate: T) => number, reach: number): T | undefined {
  let [best, least]: [T | undefined, number] = [undefined, reach];
  for (const candidate of candidates) {
    const d = far(candidate);
    if (d <= least) [best, least] = [candidate, d];
  }
  return best;
}

// Where a point that is shown at `p` is meant to be: the corner, else the place on a wall, within reach.
export function snapped(graph: Graph, p: Point, reach: number): Point {
  const corner = nearest(cornersOf(graph), (c) => distance(c, p), reach);
  if (corner) return corner;
  const wall = nearest([...graph.walls], (w) => distance(nearestOn(w, p), p), reach);
  return wall ? nearestOn(wall, p) : p;
}

// What is meant at `p`: a corner before a door before a wall.
export function elementAt(graph: Graph, p: Point, reach: number): Element | undefined {
  const corner = nearest(cornersOf(graph), (c) => distance(c, p), reach);
  if (corner) return { kind: 'corner', at: corner };
  for (const [kind, lines] of [['door', graph.doors], ['wall', graph.walls]] as const) {
    const index = nearest(lines.map((_, i) => i), (i) => distance(nearestOn(lines[i]!, p), p), reach);
    if (index !== undefined) return { kind, index };
  }
  return undefined;
}

// The element after (1) or before (-1) another, for those who use no pointer: walls, doors, then corners.
export function neighbour(graph: Graph, element: Element | undefined, step: 1 | -1): Element | undefined {
  const corners = cornersOf(graph);
  const [walls, doors] = [graph.walls.length, graph.doors.length];
  const count = walls + doors + corners.length;
  if (count === 0) return undefined;
  let at = step === 1 ? -1 : count;
  if (element?.kind === 'wall') at = element.index;
  else if (element?.kind === 'door') at = walls + element.index;
  else if (element) at = walls + doors + corners.findIndex((c) => isSame(c, element.at));
  const next = (at + step + count) % count;
  if (next < walls) return { kind: 'wall', index: next };
  return next < walls + doors ? { kind: 'door', index: next - walls } : { kind: 'corner', at: corners[next - walls - doors]! };
}

// Its middle.
export function placeOf(graph: Graph, element: Element): Point | undefined {
  if (element.kind === 'corner') return element.at;
  const line = element.kind === 'wall' ? graph.walls[element.index] : graph.doors[element.index];
  return line && { x: (line.from.x + line.to.x) / 2, y: (line.from.y + line.to.y) / 2 };
}
