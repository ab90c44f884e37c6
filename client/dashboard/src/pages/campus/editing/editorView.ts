// SPDX-License-Identifier: Apache-2.0
// What the scene draws while the graph is edited.
import type { AnchorPlace } from '../../../graph/draft';
import type { Effects } from '../../../graph/preview';
import type { LiveSite } from '../../../live/site';
import type { Pose } from '../../../scene/camera';
import type { Pin, View } from '../../../scene/model';
import { chained } from '../../../scene/se2';
import type { Pair } from './useAlign';

// The graph as it was when a drag began: what comes meanwhile waits for its end.
export interface Held {
  version: bigint;
  places: ReadonlyMap<string, Pose>;
}

export function hold(site: LiveSite): Held {
  const places = new Map<string, Pose>();
  for (const { map, poseWorldMap } of site.maps.values()) if (poseWorldMap?.pose) places.set(map, poseWorldMap.pose);
  return { version: site.graphVersion, places };
}

// T_world_map that handles and ghosts are drawn by.
export const frameOf = (site: LiveSite, held: Held | undefined, map: string): Pose | undefined => held?.places.get(map) ?? site.maps.get(map)?.poseWorldMap?.pose;

// Where the selected anchors come to lie.
function pinsOf(effects: Effects, anchors: ReadonlyMap<string, AnchorPlace>): Pin[] {
  return [...anchors].flatMap(([map, { pose }]) => {
    const frame = effects.places.get(map);
    return frame ? [{ name: `becomes ${map}`, at: chained(frame, pose), active: true }] : [];
  });
}

interface Shown {
  site: LiveSite;
  level: number | undefined;
  selected: string | undefined;
  held: Held | undefined;
  effects: Effects | undefined;
  anchors: ReadonlyMap<string, AnchorPlace>;
}

// Maps where they would be, and as ghosts where they are.
export function viewOfDraft({ site, level, selected, held, effects, anchors }: Shown): View {
  const shifted = new Map(held?.places);
  for (const [map, pose] of effects?.places ?? []) shifted.set(map, pose);
  const moves = effects?.moves.map(({ map, from, to }) => ({ map, from: frameOf(site, held, map) ?? from, to })) ?? [];
  return {
    level, selected, still: held !== undefined, shifted: shifted.size > 0 ? shifted : undefined, ghosts: moves.map(({ map, from }) => ({ map, pose: from })), moves,
    pins: effects ? pinsOf(effects, anchors) : [],
  };
}

// The walls of two maps, one over the other, and nothing else.
export function viewOfPair(site: LiveSite, { a, b, guess }: Pair): View & { base: Pose } {
  const base = site.maps.get(a)?.poseWorldMap?.pose ?? { x: 0, y: 0, yaw: 0 };
  const choice = (map: string, role: 'before' | 'after') => {
    const raster = site.rasters.get(map);
    return raster ? [{ map, revision: raster.revision, role }] : [];
  };
  return { base, places: new Map([[a, base], [b, chained(base, guess)]]), rasters: [...choice(a, 'before'), ...choice(b, 'after')], compare: 'difference', still: true };
}
