// SPDX-License-Identifier: Apache-2.0
import type { GetRasterManifestResponse } from '../../gen/enfilade/v1/raster_service_pb';
import type { Point, Pose } from '../camera';

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
  // The middle of what is known, in cells: where a name belongs.
  middle: Point;
}

export const THUMBNAIL = 64;

export const hex = (bytes: Uint8Array) => Array.from(bytes, (byte) => byte.toString(16).padStart(2, '0')).join('');

const poseOf = (pose: { x: number; y: number; yaw: number } | undefined): Pose => ({ x: pose?.x ?? 0, y: pose?.y ?? 0, yaw: pose?.yaw ?? 0 });

export const at = (row: number, column: number) => `${row},${column}`;

export function manifestOf(answer: GetRasterManifestResponse): Manifest {
  const levels: Tile[][] = [];
  for (const level of answer.levels) levels[level.zoom] = level.tiles.map(({ row, column, sha256 }) => ({ row, column, key: hex(sha256) }));
  for (let zoom = 0; zoom < levels.length; ++zoom) levels[zoom] ??= [];
  const index = levels.map((tiles) => new Map(tiles.map(({ row, column, key }) => [at(row, column), key])));
  return { revision: answer.revision, resolution: answer.resolutionM, pose: poseOf(answer.poseMapTiles), classes: answer.classes, levels, index };
}

// Of all cells that are known.
export function middleOf(cells: Uint8Array, width: number): Point {
  let [x, y, n] = [0, 0, 0];
  for (let i = 0; i < cells.length; ++i) {
    if (cells[i] === 0) continue;
    x += (i % width) + 0.5;
    y += Math.floor(i / width) + 0.5;
    ++n;
  }
  return n === 0 ? { x: width / 2, y: cells.length / width / 2 } : { x: x / n, y: y / n };
}

// The zoom at which a cell is at least one device pixel: the smallest such, so that no detail that fits is lost.
export function zoomFor(manifest: Manifest, pixelsPerMetre: number): number {
  const zoom = Math.ceil(Math.log2(1 / (manifest.resolution * pixelsPerMetre)));
  return Math.min(Math.max(0, zoom), manifest.levels.length - 1);
}
