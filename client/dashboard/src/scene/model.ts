// SPDX-License-Identifier: Apache-2.0
import type { LiveSite } from '../live/site';
import type { Area } from './areas';
import type { Bounds, Camera, Point, Pose, Size } from './camera';
import type { Plan } from './plans';

// A place that the page marks; the active one is being chosen.
export interface Pin {
  name: string;
  at: Point;
  active: boolean;
}

// Where something drove, and where it is on its way.
export interface Path {
  // What drove.
  name: string;
  // x, y, yaw of each moment, in the frame that the page shows.
  poses: Float64Array;
  // Counts poses.
  at: number;
}

// One revision of a map to draw, instead of what the site has.
export interface RasterChoice {
  map: string;
  revision: string;
  role: 'only' | 'before' | 'after';
}

export type Compare = 'blink' | 'swipe' | 'difference';

// A map that is at another place than it was.
export interface MapMove {
  map: string;
  // T_world_map.
  from: Pose;
  to: Pose;
}

// A map as it was: pale, below the others.
export interface MapGhost {
  map: string;
  // T_world_map.
  pose: Pose;
}

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
  // Where the robots come from.
  trails?: boolean | undefined;
  measuring?: boolean | undefined;
  // Further maps and link points that explain the selection.
  chain?: Point[] | undefined;
  searchRadius?: { at: Point; radius: number } | undefined;
  // Where the maps are, instead of where the graph has them now. Link points and robots, of which only the present place is
  // known, are left out then.
  places?: ReadonlyMap<string, Pose> | undefined;
  // Maps that are drawn elsewhere than the graph has them: what is in them follows. `ghosts`: where they are.
  shifted?: ReadonlyMap<string, Pose> | undefined;
  ghosts?: readonly MapGhost[] | undefined;
  // What moves is at its place at once, as under a hand.
  still?: boolean | undefined;
  // An arrow for each, `stretch` times as long as the way of the map's middle, and an outline of where it was.
  moves?: MapMove[] | undefined;
  stretch?: number | undefined;
  // A way in the frame that is shown. Robots are left out then.
  path?: Path | undefined;
  pins?: Pin[] | undefined;
  // Floor plans, in the world.
  plans?: readonly Plan[] | undefined;
  // Areas of the map, in its frame.
  areas?: readonly Area[] | undefined;
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

// What is drawn besides objects, as in the last frame, in CSS pixels; for tests. A cursor's `to` lies a metre ahead of it.
// A plan's and an area's are its upper left and lower right corners.
export interface Mark {
  kind: 'move' | 'path' | 'cursor' | 'pin' | 'trail' | 'plan' | 'area';
  name: string;
  from: Point;
  to: Point;
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
  marks: Mark[];
}
