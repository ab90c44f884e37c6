// SPDX-License-Identifier: Apache-2.0
import { hex } from '../../api/digests';
import type { GetRasterManifestResponse } from '../../gen/enfilade/v1/raster_service_pb';
import type { Point, Pose } from '../camera';
import { THUMBNAIL_FREE } from '../palette';

export interface Tile {
  row: number;
  column: number;
  // SHA-256, hexadecimal.
  key: string;
}

// Which tiles a revision has. Levels by zoom; a cell of zoom z is 2^z cells wide.
export interface Manifest {
  revision: string;
  resolution: number;
  pose: Pose;
  classes: Uint8Array;
  levels: Tile[][];
  // Of each level, by row and column.
  index: Map<string, string>[];
}

export interface Thumbnail {
  revision: string;
  resolution: number;
  pose: Pose;
  width: number;
  height: number;
  // Of the palette: 0, THUMBNAIL_FREE, THUMBNAIL_OCCUPIED.
  cells: Uint8Array;
  layer: number;
  // In cells: where a name belongs.
  middle: Point;
}

export const THUMBNAIL = 64;

const poseOf = (pose: { x: number; y: number; yaw: number } | undefined): Pose => ({ x: pose?.x ?? 0, y: pose?.y ?? 0, yaw: pose?.yaw ?? 0 });

export const at = (row: number, column: number) => `${row},${column}`;

export function manifestOf(answer: GetRasterManifestResponse): Manifest {
  const levels: Tile[][] = [];
  for (const level of answer.levels) levels[level.zoom] = level.tiles.map(({ row, column, sha256 }) => ({ row, column, key: hex(sha256) }));
  for (let zoom = 0; zoom < levels.length; ++zoom) levels[zoom] ??= [];
  const index = levels.map((tiles) => new Map(tiles.map(({ row, column, key }) => [at(row, column), key])));
  return { revision: answer.revision, resolution: answer.resolutionM, pose: poseOf(answer.poseMapTiles), classes: answer.classes, levels, index };
}

// The cell that is furthest from everything that is not free: within the room itself, also where the map sees into others
// through doors. Distances by two sweeps (Rosenfeld and Pfaltz, 1966).
export function middleOf(cells: Uint8Array, width: number): Point {
  const height = cells.length / width;
  const far = new Uint8Array(cells.length);
  const at = (row: number, column: number) => (row < 0 || column < 0 || row >= height || column >= width ? 0 : far[row * width + column]!);
  let best = -1;
  for (let row = 0; row < height; ++row) {
    for (let column = 0; column < width; ++column) {
      const i = row * width + column;
      far[i] = cells[i] === THUMBNAIL_FREE ? 1 + Math.min(at(row - 1, column), at(row, column - 1), at(row - 1, column - 1), at(row - 1, column + 1)) : 0;
    }
  }
  for (let row = height - 1; row >= 0; --row) {
    for (let column = width - 1; column >= 0; --column) {
      const i = row * width + column;
      far[i] = Math.min(far[i]!, 1 + Math.min(at(row + 1, column), at(row, column + 1), at(row + 1, column + 1), at(row + 1, column - 1)));
      if (far[i]! > 0 && (best < 0 || far[i]! > far[best]!)) best = i;
    }
  }
  return best < 0 ? { x: width / 2, y: height / 2 } : { x: (best % width) + 0.5, y: Math.floor(best / width) + 0.5 };
}

// The zoom at which a cell is at least one device pixel: the smallest such, so that no detail that fits is lost.
export function zoomFor(manifest: Manifest, pixelsPerMetre: number): number {
  const zoom = Math.ceil(Math.log2(1 / (manifest.resolution * pixelsPerMetre)));
  return Math.min(Math.max(0, zoom), manifest.levels.length - 1);
}
