// SPDX-License-Identifier: Apache-2.0
// Shapes by their coordinates, for people who draw with the keyboard, or exactly.
import type { MapEdit } from '../gen/enfilade/v1/map_edit_pb';
import type { Point } from '../scene/camera';
import type { LatticeFrame } from './frame';
import { UNITS, type Box, type Units } from './lattice';
import { crossingOf } from './raster/polygon';
import { brushEdits, fillEdit, inMiddle, isOnLattice, lineEdits, polygonEdit, rectangleOf, type Style } from './shapes';
import { radiusOf, type Settings } from './tools/settings';

export type NumberShape = 'line' | 'rectangle' | 'polygon' | 'dot' | 'fill';
export type Measure = 'metres' | 'cells';

// How many points a shape takes.
const needs: Record<NumberShape, [least: number, most: number]> = { line: [2, 1000], rectangle: [2, 2], polygon: [3, 1000], dot: [1, 1], fill: [1, 1] };

// "1, 2; 3.5, 4", one point a line or with semicolons between.
export function parsePoints(text: string): Point[] | string {
  const parts = text.split(/[;\n]/).map((part) => part.trim()).filter((part) => part !== '');
  const points: Point[] = [];
  for (const part of parts) {
    const numbers = part.split(/[\s,]+/).map(Number);
    if (numbers.length !== 2 || !numbers.every(Number.isFinite)) return `“${part}” is not a point: write x, y, for example 1.5, -2.`;
    points.push({ x: numbers[0]!, y: numbers[1]! });
  }
  return points;
}

function unitsOf(frame: LatticeFrame, measure: Measure, point: Point): Units {
  return measure === 'metres' ? frame.units(point) : { x: point.x * UNITS + UNITS / 2, y: point.y * UNITS + UNITS / 2 };
}

export interface Wanted {
  shape: NumberShape;
  measure: Measure;
  text: string;
}

function problemOf({ shape, measure }: Wanted, points: Point[], units: Units[]): string | undefined {
  const [least, most] = needs[shape];
  if (points.length < least || points.length > most) return `A ${shape} takes ${least === most ? least : `at least ${least}`} point${most === 1 ? '' : 's'}, not ${points.length}.`;
  if (measure === 'cells' && !points.every(({ x, y }) => Number.isInteger(x) && Number.isInteger(y))) return 'Cells are counted in whole numbers.';
  const outside = units.findIndex((each) => !isOnLattice(each));
  if (outside >= 0) return `Point ${outside + 1} is too far away: a coordinate is at most 2,097,151 cells.`;
  const crossing = shape === 'polygon' ? crossingOf(units) : undefined;
  return crossing && `Sides ${crossing[0] + 1} and ${crossing[1] + 1} cross: put the corners in order.`;
}

// A rectangle in metres has its sides along the axes of the map, which the cells may be turned against.
function ringOf(frame: LatticeFrame, { shape, measure }: Wanted, points: Point[], units: Units[]): Units[] {
  if (shape === 'polygon') return units;
  const [a, b] = [points[0]!, points[1]!];
  if (measure === 'cells') return rectangleOf(units[0]!, units[1]!);
  return [a, { x: b.x, y: a.y }, b, { x: a.x, y: b.y }].map((corner) => frame.units(corner));
}

// The edits, or why there are none.
export function editsOf(wanted: Wanted, frame: LatticeFrame, box: Box | undefined, settings: Settings, style: Style): MapEdit[] | string {
  const points = parsePoints(wanted.text);
  if (typeof points === 'string') return points;
  const units = points.map((point) => unitsOf(frame, wanted.measure, point));
  const problem = problemOf(wanted, points, units);
  if (problem !== undefined) return problem;
  switch (wanted.shape) {
    case 'dot':
      return brushEdits(style, settings.size === 1 ? units.map(inMiddle) : units, radiusOf(settings));
    case 'line':
      return settings.size === 1 ? lineEdits(style, units) : brushEdits(style, units, radiusOf(settings));
    case 'fill':
      return box ? [fillEdit(style, units[0]!, box)] : 'The map is still being loaded.';
    default:
      return [polygonEdit(style, ringOf(frame, wanted, points, units))];
  }
}
