// SPDX-License-Identifier: Apache-2.0
// The inbox: doors that were seen from one map and not yet passed.
import type { GraphChange } from '../gen/enfilade/v1/graph_service_pb';
import { LinkPoint_Kind as Kind, LinkPoint_Use as Use, type LinkPoint } from '../gen/enfilade/v1/link_point_pb';
import { kindNames } from './differences';
import { changesOf, editOf, movedTo, placeOf } from './draft';

export interface Wanted {
  // sites/{site}/maps/{map}; '': of all.
  map: string;
  // 0: of all.
  kind: Kind;
  pictures: 'all' | 'with' | 'without';
  text: string;
}

export const everything: Wanted = { map: '', kind: Kind.UNSPECIFIED, pictures: 'all', text: '' };

export const imagesOf = ({ evidence }: LinkPoint) => evidence.flatMap(({ content }) => (content.case === 'image' ? [content.value] : []));

export function fits(point: LinkPoint, { map, kind, pictures, text }: Wanted, titleOf: (name: string) => string): boolean {
  if (map !== '' && !point.anchors.some((anchor) => anchor.map === map)) return false;
  if (kind !== Kind.UNSPECIFIED && (point.kind || Kind.DOOR) !== kind) return false;
  if (pictures !== 'all' && (imagesOf(point).length > 0) !== (pictures === 'with')) return false;
  const words = text.toLowerCase().split(/\s+/).filter(Boolean);
  const all = `${kindNames[point.kind]} ${point.tag} ${point.name} ${point.anchors.map((anchor) => titleOf(anchor.map)).join(' ')}`.toLowerCase();
  return words.every((word) => all.includes(word));
}

// Each with its etag: none is lost that somebody has changed since it was listed.
export const deletionsOf = (points: readonly LinkPoint[]): GraphChange[] => changesOf(new Map(points.map((point) => [point.name, { ...editOf(point), isDeleted: true }])));

export const suspensionsOf = (points: readonly LinkPoint[]): GraphChange[] =>
  changesOf(new Map(points.filter(({ use }) => use !== Use.SUSPENDED).map((point) => [point.name, { ...editOf(point), use: 'suspended' as const }])));

// Candidates of one map on the line that fits them best (least squares of the distances to it), for doors along a corridor
// that were seen one by one. Undefined: fewer than three, or of several maps.
export function linedUp(points: readonly LinkPoint[]): { changes: GraphChange[]; farthest: number } | undefined {
  const anchors = points.flatMap(({ anchors: [anchor] }) => (anchor ? [anchor] : []));
  const map = anchors[0]?.map;
  if (map === undefined || anchors.length < 3 || anchors.length < points.length || anchors.some((anchor) => anchor.map !== map)) return undefined;
  const poses = anchors.map((anchor) => placeOf(anchor).pose);
  const [cx, cy] = [poses.reduce((total, { x }) => total + x, 0) / poses.length, poses.reduce((total, { y }) => total + y, 0) / poses.length];
  const [xx, xy, yy] = poses.reduce(([a, b, c], { x, y }) => [a + (x - cx) ** 2, b + (x - cx) * (y - cy), c + (y - cy) ** 2], [0, 0, 0] as [number, number, number]);
  const direction = 0.5 * Math.atan2(2 * xy, xx - yy);
  const [dx, dy] = [Math.cos(direction), Math.sin(direction)];
  let farthest = 0;
  const edits = points.map((point, i) => {
    const { x, y, yaw } = poses[i]!;
    const along = (x - cx) * dx + (y - cy) * dy;
    const to = { x: cx + along * dx, y: cy + along * dy, yaw };
    farthest = Math.max(farthest, Math.hypot(to.x - x, to.y - y));
    return [point.name, movedTo(editOf(point), map, to)] as const;
  });
  return { changes: changesOf(new Map(edits)), farthest };
}

// A request takes so many changes.
export const MOST_CHANGES = 100;

// In portions of one request.
export const portions = (changes: readonly GraphChange[]): GraphChange[][] =>
  Array.from({ length: Math.ceil(changes.length / MOST_CHANGES) }, (_, i) => changes.slice(i * MOST_CHANGES, (i + 1) * MOST_CHANGES));
