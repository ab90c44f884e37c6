// SPDX-License-Identifier: Apache-2.0
// Where the maps are: on a page of one map that one alone at the origin, else as the view has them, else as the graph has.
import type { LiveSite } from '../live/site';
import type { Pose } from './camera';
import type { View } from './model';

const ORIGIN: Pose = { x: 0, y: 0, yaw: 0 };

export function placeOfMap(site: LiveSite, view: View, map: string): Pose | undefined {
  if (view.map !== undefined) return view.map === map ? ORIGIN : undefined;
  return view.places ? view.places.get(map) : site.maps.get(map)?.poseWorldMap?.pose;
}

export function eachPlace(site: LiveSite, view: View, visit: (map: string, pose: Pose) => void) {
  if (view.map !== undefined) return visit(view.map, ORIGIN);
  if (view.places) return view.places.forEach((pose, map) => visit(map, pose));
  for (const { map, poseWorldMap } of site.maps.values()) if (poseWorldMap?.pose) visit(map, poseWorldMap.pose);
}
