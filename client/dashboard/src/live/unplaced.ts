// SPDX-License-Identifier: Apache-2.0
import { idOf } from '../api/names';
import { titleOf } from './objects';
import type { LiveSite } from './site';

export interface Unplaced {
  name: string;
  title: string;
  kind: 'map' | 'robot';
  // Why it has no place in the world, and what gives it one.
  reason: string;
}

const mapReason = (site: LiveSite, map: string) =>
  [...site.linkPoints.values()].some((point) => point.maps.includes(map))
    ? 'Its link points join it to no map that is joined to the root. Drive a robot through a door to a placed map, or add an anchor there.'
    : 'It has no link points. Drive a robot through one of its doors, or add a link point by hand.';

// A map that nobody has mapped has a place at most, but no picture.
const EMPTY = 'Nothing is mapped in it yet. Drive a robot in it, or import a file by “enfilade map import”.';

// Maps and robots that cannot be drawn; never left out in silence.
export function unplacedOf(site: LiveSite, level: number | undefined): Unplaced[] {
  const found: Unplaced[] = [];
  for (const map of site.maps.values()) {
    if (level !== undefined && map.level !== level) continue;
    const drawable = site.rasters.has(map.map);
    if (map.poseWorldMap && drawable) continue;
    found.push({ name: map.map, title: map.displayName, kind: 'map', reason: drawable ? mapReason(site, map.map) : EMPTY });
  }
  const { robots } = site;
  for (let row = 0; row < robots.count; ++row) {
    if (robots.placed[row] || (level !== undefined && robots.level[row] !== level)) continue;
    const name = robots.names[row]!;
    const reason = `Its map “${titleOf(site, robots.maps[row]!)}” is not joined to the root.`;
    found.push({ name, title: idOf(name), kind: 'robot', reason });
  }
  return found;
}
