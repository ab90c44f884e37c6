// SPDX-License-Identifier: Apache-2.0
import { affineOf, apply, boundsOf, composed, type Affine } from './affine';
import type { Bounds, Point, Pose } from './camera';
import type { Thumbnail } from './tiles/manifest';

// Where a map's picture lies in the world: what each frame needs of it, whatever the camera does.
export interface Outline {
  pose: Pose;
  thumbnail: Thumbnail;
  // T_world_cells of the thumbnail.
  cells: Affine;
  bounds: Bounds;
  middle: Point;
  // Metres.
  halfX: number;
  halfY: number;
  angle: number;
  // Where its name belongs.
  label: Point;
}

export const thumbnailAffine = (worldMap: Affine, { pose, resolution }: Thumbnail) => composed(worldMap, affineOf(pose, resolution));

function outlineOf(pose: Pose, thumbnail: Thumbnail): Outline {
  const cells = thumbnailAffine(affineOf(pose), thumbnail);
  const { width, height, resolution } = thumbnail;
  return {
    pose, thumbnail, cells, bounds: boundsOf(cells, 0, 0, width, height), middle: apply(cells, { x: width / 2, y: height / 2 }),
    halfX: (width / 2) * resolution, halfY: (height / 2) * resolution, angle: Math.atan2(cells.b, cells.a), label: apply(cells, thumbnail.middle),
  };
}

// Computed anew only for a map that has moved or has another picture: most frames move only the camera.
export class Outlines {
  private readonly known = new Map<string, Outline>();

  of(map: string, pose: Pose, thumbnail: Thumbnail | undefined): Outline | undefined {
    if (!thumbnail) return undefined;
    const found = this.known.get(map);
    if (found?.pose === pose && found.thumbnail === thumbnail) return found;
    const made = outlineOf(pose, thumbnail);
    this.known.set(map, made);
    return made;
  }

  clear() {
    this.known.clear();
  }
}
