// SPDX-License-Identifier: Apache-2.0
import { affineOf, boundsOf, composed, inverted, overlap, type Affine } from '../affine';
import type { Bounds } from '../camera';
import { at, zoomFor, type Manifest, type Thumbnail } from './manifest';
import { TILE } from './pages';

// A rectangle to draw, in metres from the corner of the lattice of tiles, and where its cells are.
export interface Patch {
  x0: number;
  y0: number;
  x1: number;
  y1: number;
  // The tile, or the thumbnail.
  key: string | undefined;
  u0: number;
  v0: number;
  u1: number;
  v1: number;
}

// T_world_lattice of a manifest whose map lies at T_world_map.
export const latticeOf = (worldMap: Affine, manifest: Manifest) => composed(worldMap, affineOf(manifest.pose));

function fromAncestor(manifest: Manifest, zoom: number, row: number, column: number, has: (key: string) => boolean): Omit<Patch, 'x0' | 'y0' | 'x1' | 'y1'> | undefined {
  for (let up = 0; zoom + up < manifest.levels.length; ++up) {
    const key = manifest.index[zoom + up]!.get(at(row >> up, column >> up));
    if (key === undefined || !has(key)) continue;
    const size = TILE / 2 ** up;
    const u0 = (column - ((column >> up) << up)) * size;
    const v0 = (row - ((row >> up) << up)) * size;
    return { key, u0, v0, u1: u0 + size, v1: v0 + size };
  }
  return undefined;
}

// Of a thumbnail what lies in the rectangle, which is cut to it.
function fromThumbnail(manifest: Manifest, thumbnail: Thumbnail, x0: number, y0: number, x1: number, y1: number): Patch | undefined {
  const lattice = composed(inverted(affineOf(manifest.pose)), affineOf(thumbnail.pose));
  const cut = (low: number, high: number, origin: number, length: number) =>
    [Math.max(low, origin), Math.min(high, origin + length * thumbnail.resolution)] as const;
  const [cx0, cx1] = cut(x0, x1, lattice.e, thumbnail.width);
  const [cy0, cy1] = cut(y0, y1, lattice.f, thumbnail.height);
  if (cx0 >= cx1 || cy0 >= cy1) return undefined;
  const texel = (value: number, origin: number) => (value - origin) / thumbnail.resolution;
  return {
    x0: cx0, y0: cy0, x1: cx1, y1: cy1, key: undefined,
    u0: texel(cx0, lattice.e), v0: texel(cy0, lattice.f), u1: texel(cx1, lattice.e), v1: texel(cy1, lattice.f),
  };
}

export interface Cover {
  patches: Patch[];
  // Tiles that the view wants and the cache does not have.
  missing: string[];
}

// What to draw of a revision: the tiles of the zoom that fits; where one is missing the part of a coarser one, at last of the
// thumbnail.
export function coverOf(manifest: Manifest, thumbnail: Thumbnail | undefined, worldMap: Affine, view: Bounds, pixelsPerMetre: number, has: (key: string) => boolean): Cover {
  const zoom = zoomFor(manifest, pixelsPerMetre);
  const size = TILE * manifest.resolution * 2 ** zoom;
  const seen = inverted(latticeOf(worldMap, manifest));
  const window = boundsOf(seen, view.minX, view.minY, view.maxX, view.maxY);
  const cover: Cover = { patches: [], missing: [] };
  for (const { row, column, key } of manifest.levels[zoom] ?? []) {
    const [x0, y0] = [column * size, row * size];
    const [x1, y1] = [x0 + size, y0 + size];
    if (!overlap({ minX: x0, minY: y0, maxX: x1, maxY: y1 }, window)) continue;
    if (!has(key)) cover.missing.push(key);
    const found = fromAncestor(manifest, zoom, row, column, has);
    if (found) {
      cover.patches.push({ x0, y0, x1, y1, ...found });
    } else if (thumbnail) {
      const patch = fromThumbnail(manifest, thumbnail, x0, y0, x1, y1);
      if (patch) cover.patches.push(patch);
    }
  }
  return cover;
}
