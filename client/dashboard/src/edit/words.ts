// SPDX-License-Identifier: Apache-2.0
import { CLEAR, editedOf, FREE, OCCUPIED, shownOf, UNKNOWN, type Value } from './cells';
import type { ToolName } from './tools/settings';

export const valueNames: Record<Value, string> = { [FREE]: 'Free', [OCCUPIED]: 'Occupied', [UNKNOWN]: 'Unknown', [CLEAR]: 'Clear edits' };
export const values: readonly Value[] = [FREE, OCCUPIED, UNKNOWN, CLEAR];
export const classes: readonly Value[] = [FREE, OCCUPIED, UNKNOWN];

export const toolNames: Record<ToolName, string> = { brush: 'Brush', line: 'Line', rectangle: 'Rectangle', polygon: 'Polygon', fill: 'Fill', area: 'Area' };

const number = (n: bigint | number) => n.toLocaleString('en');

// "412 cells become free, 30 become occupied".
export function changesText(changes: { toFree: bigint; toOccupied: bigint; toUnknown: bigint } | undefined): string {
  const parts = ([['free', changes?.toFree], ['occupied', changes?.toOccupied], ['unknown', changes?.toUnknown]] as const)
    .filter(([, count]) => (count ?? 0n) > 0n)
    .map(([what, count], i) => `${number(count!)}${i === 0 ? (count === 1n ? ' cell' : ' cells') : ''} become${count === 1n ? 's' : ''} ${what}`);
  return parts.length === 0 ? 'No cell changes' : parts.join(', ');
}

// "A, B and C".
export function listed(names: readonly string[]): string {
  const known = [...new Set(names)].map((name) => (name === '' ? 'somebody' : name));
  if (known.length < 2) return known[0] ?? 'somebody';
  return `${known.slice(0, -1).join(', ')} and ${known.at(-1)}`;
}

// "free", "occupied, edited", of the byte of a cell.
export function cellText(cell: number): string {
  return `${valueNames[shownOf(cell) as Value].toLowerCase()}${editedOf(cell) === 0 ? '' : ', edited'}`;
}

// "occupied from 65 %, free up to 25 %, and unknown between", of the classes of the 256 values of a cell (RasterService).
export function thresholdsText(classes: Uint8Array): string | undefined {
  const percent = (value: number) => `${Math.round((100 * (value - 1)) / 254)} %`;
  const [free, occupied] = [classes.lastIndexOf(1), classes.indexOf(2)];
  return free < 1 || occupied < 1 ? undefined : `occupied from ${percent(occupied)}, free up to ${percent(free)}${occupied - free > 1 ? ', and unknown between' : ''}`;
}
