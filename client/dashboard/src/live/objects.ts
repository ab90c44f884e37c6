// SPDX-License-Identifier: Apache-2.0
import { idOf } from '../api/names';
import { shortened } from '../ui/format';
import type { LiveSite } from './site';
import { LinkPoint_Kind, LinkPoint_State, LinkPoint_Use } from '../gen/enfilade/v1/link_point_pb';
import type { GraphLinkPoint } from '../gen/enfilade/v1/graph_pb';

const kinds: Record<LinkPoint_Kind, string> = {
  [LinkPoint_Kind.UNSPECIFIED]: 'Door',
  [LinkPoint_Kind.DOOR]: 'Door',
  [LinkPoint_Kind.LIFT]: 'Lift',
  [LinkPoint_Kind.STAIRS]: 'Stairs',
  [LinkPoint_Kind.RAMP]: 'Ramp',
  [LinkPoint_Kind.OPENING]: 'Opening',
};

export const kindOf = (point: GraphLinkPoint) => kinds[point.kind];

// What a person needs to know of it, the most important first.
export function stateOf(point: GraphLinkPoint): { tone: 'good' | 'warn' | 'bad' | 'quiet'; text: string } {
  if (point.use === LinkPoint_Use.SUSPENDED) return { tone: 'quiet', text: 'Suspended' };
  if (point.use === LinkPoint_Use.SWITCHED_OFF) return { tone: 'bad', text: 'Switched off: contradicts the others' };
  if (point.maps.length < 2) return { tone: 'warn', text: 'Candidate: seen from one map' };
  if (point.state === LinkPoint_State.BLOCKED) return { tone: 'bad', text: 'Blocked' };
  if (point.state === LinkPoint_State.CLOSED) return { tone: 'warn', text: 'Closed' };
  return { tone: 'good', text: 'Open' };
}

// The levels that a link point is on.
export function levelsOf(site: LiveSite, point: GraphLinkPoint): number[] {
  return [...new Set(point.maps.flatMap((name) => site.maps.get(name)?.level ?? []))];
}

// What people call it: a map by its name, a link point by the maps that it joins, since its id is often a UUID.
export function titleOf(site: LiveSite, name: string): string {
  const map = site.maps.get(name);
  if (map) return map.displayName;
  const point = site.linkPoints.get(name);
  if (point) return `${kindOf(point)} ${point.maps.map((one) => site.maps.get(one)?.displayName ?? idOf(one)).join(' – ')}`;
  return idOf(name);
}

// The same, and which one it is where several of a kind join the same maps.
export function distinctTitleOf(site: LiveSite, name: string): string {
  const title = titleOf(site, name);
  if (!site.linkPoints.has(name)) return title;
  for (const other of site.linkPoints.keys()) if (other !== name && titleOf(site, other) === title) return `${title} (${shortened(idOf(name))})`;
  return title;
}
