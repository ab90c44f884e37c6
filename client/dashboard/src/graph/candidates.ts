// SPDX-License-Identifier: Apache-2.0
// The inbox: doors that were seen from one map and not yet passed.
import { create } from '@bufbuild/protobuf';
import { GraphChangeSchema, type GraphChange } from '../gen/enfilade/v1/graph_service_pb';
import { LinkPoint_Kind as Kind, LinkPoint_Use as Use, type LinkPoint } from '../gen/enfilade/v1/link_point_pb';
import { kindNames } from './differences';
import { changesOf, editOf } from './draft';

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

// A request takes so many changes.
export const MOST_CHANGES = 100;

// In portions of one request; what belongs to one link point stays together.
export function portions(changes: readonly GraphChange[]): GraphChange[][] {
  const out: GraphChange[][] = [];
  const nameOf = ({ change }: GraphChange) => (typeof change.value === 'string' ? change.value : (change.value?.name ?? ''));
  for (let i = 0; i < changes.length; ) {
    let end = i + 1;
    while (end < changes.length && nameOf(changes[end]!) === nameOf(changes[i]!)) ++end;
    const group = changes.slice(i, end).map((one) => create(GraphChangeSchema, one));
    const last = out.at(-1);
    if (last && last.length + group.length <= MOST_CHANGES) last.push(...group);
    else out.push(group);
    i = end;
  }
  return out;
}
