// SPDX-License-Identifier: Apache-2.0
// Where the walls of a plan lie as its alignment has placed it as a whole.
import type { PriorMap } from '../../gen/enfilade/v1/prior_map_pb';
import type { Point } from '../../scene/camera';
import { boundsOfLines, type Plan, type PlanLine } from '../../scene/plans';
import type { Graph } from './editing/graph';

// From the sheet to the world, by affine_world_sheet.
export function onWorld([a, b, c, d, e, f]: number[]): (sheet: Point) => Point {
  return ({ x, y }) => ({ x: a! * x + b! * y + c!, y: d! * x + e! * y + f! });
}

export function placedPlan({ name, level, alignment }: Pick<PriorMap, 'name' | 'level' | 'alignment'>, { walls, doors }: Graph): Plan {
  const place = onWorld(alignment?.affineWorldSheet ?? []);
  const line = (kind: 'wall' | 'door') => ({ from, to }: { from: Point; to: Point }): PlanLine => ({ from: place(from), to: place(to), kind, state: 'placed' });
  const lines = alignment?.affineWorldSheet.length === 6 ? [...walls.map(line('wall')), ...doors.map(line('door'))] : [];
  return { name, level, lines, bounds: boundsOfLines(lines) };
}

// m: how far ends of walls were moved. Both have the plan's own lines in the same order; undefined: they have not.
export function movedBy(placed: Plan, corrected: Plan): { median: number; most: number } | undefined {
  const own = corrected.lines.filter(({ state }) => state !== 'added');
  if (placed.lines.length === 0 || placed.lines.length !== own.length) return undefined;
  const moved = placed.lines.flatMap((line, i) => {
    const { from, to } = own[i]!;
    return [Math.hypot(from.x - line.from.x, from.y - line.from.y), Math.hypot(to.x - line.to.x, to.y - line.to.y)];
  }).sort((a, b) => a - b);
  return { median: moved[Math.floor(moved.length / 2)]!, most: moved.at(-1)! };
}
