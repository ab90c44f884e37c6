// SPDX-License-Identifier: Apache-2.0
import type { Pose } from '../../scene/camera';
import { middleAt } from '../../scene/moves';
import type { Thumbnail } from '../../scene/tiles/manifest';

// Where maps are in the world, by name.
export type Places = ReadonlyMap<string, Pose>;

export interface Movement {
  map: string;
  from: Pose;
  to: Pose;
  // Of the middle of its picture, m.
  distance: number;
  // Counter-clockwise, rad, in (-pi, pi].
  turn: number;
}

export interface Difference {
  // The farthest first.
  moved: Movement[];
  still: number;
  // Placed only later, and only before.
  appeared: string[];
  gone: string[];
}

// Less than these is rounding, not movement.
const STILL_M = 0.0005;
const STILL_RAD = 0.0001;

function movementOf(map: string, from: Pose, to: Pose, thumbnail: Thumbnail | undefined): Movement {
  const [a, b] = [middleAt(from, thumbnail), middleAt(to, thumbnail)];
  const turn = to.yaw - from.yaw;
  return { map, from, to, distance: Math.hypot(b.x - a.x, b.y - a.y), turn: Math.atan2(Math.sin(turn), Math.cos(turn)) };
}

// What has moved between two placings of the maps.
export function differenceOf(before: Places, after: Places, thumbnails: ReadonlyMap<string, Thumbnail>): Difference {
  const both = [...after].flatMap(([map, to]) => {
    const from = before.get(map);
    return from ? [movementOf(map, from, to, thumbnails.get(map))] : [];
  });
  const moved = both.filter(({ distance, turn }) => distance > STILL_M || Math.abs(turn) > STILL_RAD);
  return {
    moved: moved.sort((a, b) => b.distance - a.distance || Math.abs(b.turn) - Math.abs(a.turn)),
    still: both.length - moved.length,
    appeared: [...after.keys()].filter((map) => !before.has(map)),
    gone: [...before.keys()].filter((map) => !after.has(map)),
  };
}
