// SPDX-License-Identifier: Apache-2.0
// The cells of a map, and integer coordinates on them: 1/256 of a cell (proto/enfilade/v1/map_edit.proto).

export const UNITS = 256; // of a cell's side
export const TILE = 256; // cells of a tile's side
export const MAX_COORDINATE = 2 ** 29;
export const MAX_SIDE = 2 ** 22; // of a segment, along each axis
export const MAX_RADIUS = 65_536;
export const MAX_POINTS = 10_000;
export const MAX_CELLS = 4_000_000; // of one edit

// A point in units.
export interface Units {
  x: number;
  y: number;
}

// Cells, from the first to before the end.
export interface Box {
  firstColumn: number;
  firstRow: number;
  width: number;
  height: number;
}

// Divisions by a power of two are exact.
export const centreOf = (cell: number) => UNITS * cell + UNITS / 2;
export const cellOf = (units: number) => Math.floor(units / UNITS);
// The first cell whose centre is not below, and the last whose centre is not above.
export const firstFrom = (units: number) => Math.ceil((units - UNITS / 2) / UNITS);
export const lastUpTo = (units: number) => Math.floor((units - UNITS / 2) / UNITS);

// Exact for |value| < 2^53 and divisor > 0: the quotient of floats may be off by one.
export function floorDiv(value: number, divisor: number): number {
  const quotient = Math.floor(value / divisor);
  const rest = value - quotient * divisor;
  return rest < 0 ? quotient - 1 : rest >= divisor ? quotient + 1 : quotient;
}
export const ceilDiv = (value: number, divisor: number) => -floorDiv(-value, divisor);

// Tiles are within +-2^14, whatever the coordinates.
const OFFSET = 2 ** 15;
export const tileKey = (row: number, column: number) => (row + OFFSET) * 2 * OFFSET + column + OFFSET;
export const placeOf = (key: number) => ({ row: Math.floor(key / (2 * OFFSET)) - OFFSET, column: (key % (2 * OFFSET)) - OFFSET });
export const tileOf = (cell: number) => Math.floor(cell / TILE);

export function united(a: Box | undefined, b: Box): Box {
  if (!a) return b;
  const firstColumn = Math.min(a.firstColumn, b.firstColumn);
  const firstRow = Math.min(a.firstRow, b.firstRow);
  const width = Math.max(a.firstColumn + a.width, b.firstColumn + b.width) - firstColumn;
  return { firstColumn, firstRow, width, height: Math.max(a.firstRow + a.height, b.firstRow + b.height) - firstRow };
}
