// SPDX-License-Identifier: Apache-2.0
// What a person draws, as edits.
import { create } from '@bufbuild/protobuf';
import { MapEditSchema, type MapEdit, type MapEdit_Value } from '../gen/enfilade/v1/map_edit_pb';
import type { Value } from './cells';
import { uuid } from './ids';
import { cellOf, MAX_COORDINATE, MAX_POINTS, MAX_SIDE, UNITS, type Box, type Units } from './lattice';

// How it is drawn, whatever the shape is.
export interface Style {
  value: Value;
  // Only cells that show one of these; empty: all.
  onlyWhere: Value[];
  invisible: boolean;
  author: string;
}

function editOf({ value, onlyWhere, invisible, author }: Style, shape: MapEdit['shape']): MapEdit {
  return create(MapEditSchema, { editId: uuid(), value: value as MapEdit_Value, onlyWhere: onlyWhere as MapEdit_Value[], invisible, author, shape: shape as never });
}

const plain = ({ x, y }: Units) => ({ x, y });

// The server goes over at most 64,000,000 cells of an edit, counting those again that lie near several segments.
const MAX_PASSED = 50e6;

// About how many cells lie within a radius of a segment.
function passed(a: Units, b: Units, radius: number): number {
  const [r, length] = [radius / UNITS + 1, Math.hypot(b.x - a.x, b.y - a.y) / UNITS];
  return 2 * r * length + 4 * r * r;
}

// Parts of a path that the server takes: each begins where the one before ends.
function partsOf(points: readonly Units[], radius = 0): Units[][] {
  const short: Units[] = [];
  for (const point of points) {
    const before = short.at(-1);
    if (before) {
      const pieces = Math.ceil(Math.max(Math.abs(point.x - before.x), Math.abs(point.y - before.y)) / MAX_SIDE);
      for (let i = 1; i < pieces; ++i) {
        short.push({ x: Math.round(before.x + ((point.x - before.x) * i) / pieces), y: Math.round(before.y + ((point.y - before.y) * i) / pieces) });
      }
    }
    short.push(plain(point));
  }
  const parts: Units[][] = [[short[0]!]];
  let cells = 0;
  for (let i = 1; i < short.length; ++i) {
    const part = parts.at(-1)!;
    cells += passed(short[i - 1]!, short[i]!, radius);
    if (part.length < MAX_POINTS && (part.length === 1 || cells <= MAX_PASSED)) {
      part.push(short[i]!);
    } else {
      parts.push([short[i - 1]!, short[i]!]);
      cells = passed(short[i - 1]!, short[i]!, radius);
    }
  }
  return parts;
}

export const brushEdits = (style: Style, points: readonly Units[], radius: number) =>
  partsOf(points, radius).map((part) => editOf(style, { case: 'brush', value: { points: part, radius } as never }));

export const lineEdits = (style: Style, points: readonly Units[]) =>
  partsOf(points).map((part) => editOf(style, { case: 'line', value: { points: part } as never }));

export const polygonEdit = (style: Style, ring: readonly Units[]) =>
  editOf(style, { case: 'polygon', value: { rings: [{ points: ring.map(plain) }] } as never });

export const fillEdit = (style: Style, seed: Units, bounds: Box) =>
  editOf(style, { case: 'fill', value: { seed: plain(seed), bounds: { ...bounds } } as never });

// The ring around all cells from that of one point to that of the other.
export function rectangleOf(a: Units, b: Units): Units[] {
  const [x0, x1] = [Math.min(cellOf(a.x), cellOf(b.x)) * UNITS, (Math.max(cellOf(a.x), cellOf(b.x)) + 1) * UNITS];
  const [y0, y1] = [Math.min(cellOf(a.y), cellOf(b.y)) * UNITS, (Math.max(cellOf(a.y), cellOf(b.y)) + 1) * UNITS];
  return [{ x: x0, y: y0 }, { x: x1, y: y0 }, { x: x1, y: y1 }, { x: x0, y: y1 }];
}

// The middle of the cell: with a brush of one cell, each point then has a cell.
export const inMiddle = ({ x, y }: Units): Units => ({ x: cellOf(x) * UNITS + UNITS / 2, y: cellOf(y) * UNITS + UNITS / 2 });

export const isOnLattice = ({ x, y }: Units) => Math.abs(x) <= MAX_COORDINATE && Math.abs(y) <= MAX_COORDINATE;
