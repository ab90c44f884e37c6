// SPDX-License-Identifier: Apache-2.0
// Where the maps are: on a page of one map that one alone at the origin, else as the view has them, else as the graph has.
import type { LiveSite } from '../live/site';
import type { Pose } from './camera';
import type { View } from './model';
import { chained, relative } from './se2';

const ORIGIN: Pose = { x: 0, y: 0, yaw: 0 };

export function placeOfMap(site: LiveSite, view: View, map: string): Pose | undefined {
  if (view.map !== undefined) return view.map === map ? ORIGIN : undefined;
  if (view.places) return view.places.get(map);
  return view.shifted?.get(map) ?? site.maps.get(map)?.poseWorldMap?.pose;
}

// Of a link point: where the shifted ones of its maps take it.
export function shiftedPlace(site: LiveSite, { shifted }: View, maps: readonly string[], place: Pose): Pose {
  if (!shifted) return place;
  for (const map of maps) {
    const [from, to] = [site.maps.get(map)?.poseWorldMap?.pose, shifted.get(map)];
    if (from && to) return chained(to, relative(from, place));
  }
  return place;
}

export function eachPlace(site: LiveSite, view: View, visit: (map: string, pose: Pose) => void) {
  if (view.map !== undefined) return visit(view.map, ORIGIN);
  if (view.places) return view.places.forEach((pose, map) => visit(map, pose));
  for (const { map, poseWorldMap } of site.maps.values()) {
    const pose = view.shifted?.get(map) ?? poseWorldMap?.pose;
    if (pose) visit(map, pose);
  }
}
