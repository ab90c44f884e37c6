// SPDX-License-Identifier: Apache-2.0
// What a cell of a tile is, in a byte as MapDraftTile.cells has it: bits 0-1 what robots have seen (0 unknown, 1 free,
// 2 occupied), bits 2-3 what edits say (0 nothing, 1 unknown, 2 free, 3 occupied), bits 4-5 the same without the draft.
import { sha256 } from '@noble/hashes/sha2.js';
import { hex } from '../api/digests';
import { TILE_CELLS } from './raster/spans';

export const UNKNOWN = 1;
export const FREE = 2;
export const OCCUPIED = 3;
export const CLEAR = 4;
// MapEdit.Value has the same numbers.
export type Value = 1 | 2 | 3 | 4;

export const editedOf = (cell: number) => (cell >> 2) & 3;
export const publishedOf = (cell: number) => (cell >> 4) & 3;

// UNKNOWN, FREE or OCCUPIED: edits lie over what robots have seen.
export const shownOf = (cell: number) => editedOf(cell) || (cell & 3) + 1;

const scratch = new Uint8Array(TILE_CELLS);

// As MapEditTile.sha256: of what edits say.
export function digestOf(cells: Uint8Array): string {
  for (let i = 0; i < TILE_CELLS; ++i) scratch[i] = (cells[i]! >> 2) & 3;
  return hex(sha256(scratch));
}
