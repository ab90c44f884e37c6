// SPDX-License-Identifier: Apache-2.0
import type { LiveSite } from '../live/site';
import type { Bounds, Camera, Point, Size } from './camera';

// One revision of a map to draw, instead of what the site has.
export interface RasterChoice {
  map: string;
  revision: string;
  role: 'only' | 'before' | 'after';
}

export type Compare = 'blink' | 'swipe' | 'difference';

// What a page wants to see. `map`: this map only, in its own frame.
export interface View {
  level?: number | undefined;
  selected?: string | undefined;
  map?: string | undefined;
  rasters?: RasterChoice[] | undefined;
  compare?: Compare | undefined;
  // The place of the border, 0 to 1 of the window.
  swipe?: number | undefined;
  follow?: boolean | undefined;
  measuring?: boolean | undefined;
  // Further maps and link points that explain the selection.
  chain?: Point[] | undefined;
  searchRadius?: { at: Point; radius: number } | undefined;
}

export type ObjectKind = 'robot' | 'link' | 'map';

// As drawn in the last frame, in CSS pixels: what a pointer hits, and what tests read.
export interface Drawn {
  name: string;
  kind: ObjectKind;
  x: number;
  y: number;
  // Pixels; of a map half its width and height.
  halfX: number;
  halfY: number;
  angle: number;
  ghost: boolean;
  // Where its name belongs.
  label: Point;
}

export interface Stats {
  frames: number;
  drawCalls: number;
  // JavaScript of the last frames, ms.
  frameMs: number[];
  tileRequests: number;
  tiles: number;
}

export interface Frame {
  site: LiveSite;
  view: View;
  camera: Camera;
  size: Size;
  window: Bounds;
  // Milliseconds: of performance.now(), and since 1970.
  now: number;
  wall: number;
  drawn: Drawn[];
}
