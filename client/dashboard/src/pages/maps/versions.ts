// SPDX-License-Identifier: Apache-2.0
// Aliases of a map, and what came and went between two of its revisions, as people read them.
import { idOf } from '../../api/names';
import type { MapAlias } from '../../gen/enfilade/v1/map_pb';
import type { DiffMapRevisionsResponse, MapDiffRegion } from '../../gen/enfilade/v1/map_service_pb';
import type { Point } from '../../scene/camera';

// What most sites have; people may choose others.
export const usualAliases = ['stable', 'canary'];

export const aliasesKey = (map: string) => ['aliases', map];

// As the server reads it: 1 to 63 of a-z, 0-9 and "-".
export const isAliasName = (text: string) => /^[a-z0-9-]{1,63}$/.test(text);

export const aliasName = (map: string, id: string) => `${map}/aliases/${id}`;

// What a person may want to lead to a revision: the usual ones and those that are there, but for those that lead there.
export function offeredAliases(aliases: readonly MapAlias[], revision: string): string[] {
  const there = aliases.filter((alias) => alias.revision === revision).map(({ name }) => idOf(name));
  return [...new Set([...usualAliases, ...aliases.map(({ name }) => idOf(name))])].filter((id) => !there.includes(id));
}

// Where an alias would be led back to; undefined: it has never led elsewhere.
export const beforeOf = ({ previousRevision }: MapAlias) => (previousRevision === '' ? undefined : idOf(previousRevision));

export interface DiffLine {
  title: string;
  // Square metres and cells.
  area: number;
  cells: number;
}

// The cells by [from][to], row by row, of unknown, free, occupied. Lines of nothing are left out.
export function diffLines({ cells, resolutionM }: Pick<DiffMapRevisionsResponse, 'cells' | 'resolutionM'>): DiffLine[] {
  const of = (...places: number[]) => places.reduce((sum, place) => sum + Number(cells[place] ?? 0n), 0);
  const lines: [title: string, cells: number][] = [
    ['Walls that came', of(2, 5)],
    ['Walls that went', of(6, 7)],
    ['Ground newly seen', of(1)],
    ['Ground no longer known', of(3)],
  ];
  return lines.filter(([, count]) => count > 0).map(([title, count]) => ({ title, cells: count, area: count * resolutionM * resolutionM }));
}

// What most of its cells have become.
export function kindOf({ toOccupied, toFree, toUnknown }: Pick<MapDiffRegion, 'toOccupied' | 'toFree' | 'toUnknown'>): string {
  if (toOccupied >= toFree && toOccupied >= toUnknown) return 'Occupied now';
  return toFree >= toUnknown ? 'Free now' : 'Unknown now';
}

const cornersOf = ({ box }: Pick<MapDiffRegion, 'box'>): Point[] => (box?.corners ?? []).map(({ x, y }) => ({ x, y }));

// m, in the map's frame.
export function middleOf(region: Pick<MapDiffRegion, 'box'>): Point | undefined {
  const corners = cornersOf(region);
  if (corners.length === 0) return undefined;
  const mean = (pick: (corner: Point) => number) => corners.reduce((sum, corner) => sum + pick(corner), 0) / corners.length;
  return { x: mean(({ x }) => x), y: mean(({ y }) => y) };
}

// Its width and height along its cells, m.
export function sizeOf(region: Pick<MapDiffRegion, 'box'>): [number, number] {
  const [a, b, , d] = cornersOf(region);
  if (!a || !b || !d) return [0, 0];
  return [Math.hypot(b.x - a.x, b.y - a.y), Math.hypot(d.x - a.x, d.y - a.y)];
}
