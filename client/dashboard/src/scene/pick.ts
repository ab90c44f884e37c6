// SPDX-License-Identifier: Apache-2.0
import { apply, inverted, type Affine } from './affine';
import type { Point } from './camera';
import type { Drawn } from './model';
import type { Thumbnail } from './tiles/manifest';

const REACH_PX = 12;

// The nearest robot or link point within reach; robots before link points, as they are drawn above them.
export function pickIcon(drawn: readonly Drawn[], at: Point): Drawn | undefined {
  let best: Drawn | undefined;
  let bestDistance = Infinity;
  for (const item of drawn) {
    if (item.kind === 'map' || item.ghost) continue;
    const distance = Math.hypot(item.x - at.x, item.y - at.y) - (item.kind === 'robot' ? 4 : 0);
    if (distance <= REACH_PX && distance < bestDistance) {
      best = item;
      bestDistance = distance;
    }
  }
  return best;
}

// Whether the map's picture knows the cell there: only what is seen can be hit.
export function knowsCell(thumbnail: Thumbnail, worldThumbnail: Affine, world: Point): boolean {
  const { x, y } = apply(inverted(worldThumbnail), world);
  const [column, row] = [Math.floor(x), Math.floor(y)];
  if (column < 0 || row < 0 || column >= thumbnail.width || row >= thumbnail.height) return false;
  return thumbnail.cells[row * thumbnail.width + column] !== 0;
}
