// SPDX-License-Identifier: Apache-2.0
import { editedOf, publishedOf, shownOf } from '../cells';
import { TILE } from '../lattice';

// Of the 64 values of a cell, the one that is seen among others: the greatest. Occupied wins, else free; what the draft has
// changed wins over what it has not.
const rank = Uint8Array.from({ length: 64 }, (_, cell) => 2 * [0, 0, 1, 2][shownOf(cell)]! + (editedOf(cell) === publishedOf(cell) ? 0 : 1));
const MOST = 2 * 2 + 1;

// The value that is seen of 2^zoom x 2^zoom cells of a tile.
export function strongest(cells: Uint8Array, row: number, column: number, zoom: number): number {
  let best = 0;
  let bestRank = -1;
  const side = 1 << zoom;
  for (let y = row << zoom; y < (row + 1) << zoom; ++y) {
    const begin = y * TILE + (column << zoom);
    for (let i = begin; i < begin + side; ++i) {
      const cell = cells[i]!;
      if (rank[cell]! <= bestRank) continue;
      best = cell;
      bestRank = rank[cell]!;
      if (bestRank === MOST) return best;
    }
  }
  return best;
}
