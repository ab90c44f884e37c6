// SPDX-License-Identifier: Apache-2.0
// Changes of link points that are not saved yet. They are kept as differences from what the server has, so that they can be
// laid on what somebody else has made of it meanwhile.
import { create } from '@bufbuild/protobuf';
import { GraphChangeSchema, type GraphChange } from '../gen/enfilade/v1/graph_service_pb';
import { AnchorSchema, LinkPointSchema, LinkPoint_Use as Use, type Anchor, type LinkPoint } from '../gen/enfilade/v1/link_point_pb';
import type { Pose } from '../scene/camera';
import { byHand, covarianceOf } from './spread';

export interface AnchorPlace {
  // T_map_place.
  pose: Pose;
  // 3x3 of (x, y, yaw), row by row.
  covariance: number[];
}

export interface Edit {
  // As the server had it; of a new one what it is to be.
  base: LinkPoint;
  isNew: boolean;
  // By map: moved or added ones; null: taken away.
  anchors: Readonly<Record<string, AnchorPlace | null>>;
  kind?: LinkPoint['kind'];
  state?: LinkPoint['state'];
  use?: 'suspended' | 'resumed';
  // Whether surveys leave it as it is; unset: they do once it has been placed by hand.
  pinned?: boolean;
  isDeleted?: boolean;
}

// By the names of link points.
export type Draft = ReadonlyMap<string, Edit>;

export const emptyDraft: Draft = new Map();

export const editOf = (base: LinkPoint): Edit => ({ base, isNew: false, anchors: {} });

export function placeOf({ poseMapPlace }: Anchor): AnchorPlace {
  const { x = 0, y = 0, yaw = 0 } = poseMapPlace?.pose ?? {};
  return { pose: { x, y, yaw }, covariance: [...(poseMapPlace?.covariance ?? [])] };
}

export const anchorOf = (map: string, { pose, covariance }: AnchorPlace): Anchor => create(AnchorSchema, { map, poseMapPlace: { pose, covariance } });

// As it would be stored: known anchors in their order, then new ones.
export function anchorsOf({ base, anchors }: Edit): Map<string, AnchorPlace> {
  const found = new Map<string, AnchorPlace>();
  for (const anchor of base.anchors) {
    const place = anchors[anchor.map];
    if (place !== null) found.set(anchor.map, place ?? placeOf(anchor));
  }
  for (const [map, place] of Object.entries(anchors)) if (place && !found.has(map)) found.set(map, place);
  return found;
}

export function wantedOf(edit: Edit): LinkPoint {
  const { base, kind = base.kind, state = base.state, pinned = base.pinned } = edit;
  // A state that is set by hand holds until it is set again.
  const stateValidUntil = state === base.state ? base.stateValidUntil : undefined;
  const { stateValidUntil: _, pinned: __, ...rest } = base;
  const anchors = anchorsOf(edit);
  const directionMap = anchors.has(base.directionMap) ? base.directionMap : '';
  return create(LinkPointSchema, { ...rest, directionMap, ...(stateValidUntil && { stateValidUntil }), kind, state, ...(pinned !== undefined && { pinned }), anchors: [...anchors].map(([map, place]) => anchorOf(map, place)) });
}

export const isSuspended = ({ base, use }: Edit) => use === 'suspended' || (use === undefined && base.use === Use.SUSPENDED);

const sameNumbers = (a: readonly number[], b: readonly number[]) => a.length === b.length && a.every((value, i) => value === b[i]);

export const samePlace = (a: AnchorPlace, b: AnchorPlace) =>
  a.pose.x === b.pose.x && a.pose.y === b.pose.y && a.pose.yaw === b.pose.yaw && sameNumbers(a.covariance, b.covariance);

// Whether it changes nothing.
export function isIdle(edit: Edit): boolean {
  const { base, isNew, state = base.state, use, pinned, isDeleted } = edit;
  if (isNew || isDeleted || use !== undefined || state !== base.state || isPlaced(edit)) return false;
  return pinned === undefined || pinned === (base.pinned ?? false);
}

// Whether it changes where the link point is, or of what kind: by that the server pins it.
function isPlaced(edit: Edit): boolean {
  const { base, kind = base.kind } = edit;
  if (kind !== base.kind) return true;
  const wanted = anchorsOf(edit);
  return wanted.size !== base.anchors.length || !base.anchors.every((anchor) => {
    const place = wanted.get(anchor.map);
    return place !== undefined && samePlace(place, placeOf(anchor));
  });
}

// A place that a hand has moved is known as exactly as a hand is, unless its spread has been entered.
export function movedTo(edit: Edit, map: string, pose: Pose): Edit {
  const place = edit.anchors[map];
  const covariance = place ? place.covariance : covarianceOf(byHand);
  return { ...edit, anchors: { ...edit.anchors, [map]: { pose, covariance } } };
}

export function spreadTo(edit: Edit, map: string, covariance: number[]): Edit {
  const place = anchorsOf(edit).get(map);
  return place ? { ...edit, anchors: { ...edit.anchors, [map]: { pose: place.pose, covariance } } } : edit;
}

export function withoutAnchor(edit: Edit, map: string): Edit {
  const isKnown = edit.base.anchors.some((anchor) => anchor.map === map);
  const { [map]: _, ...rest } = edit.anchors;
  return { ...edit, anchors: isKnown ? { ...rest, [map]: null } : rest };
}

// As the server would have it.
export const isPinned = (edit: Edit) => edit.pinned ?? (isPlaced(edit) || (edit.base.pinned ?? false));

export const pinToggled = (edit: Edit): Edit => ({ ...edit, pinned: !isPinned(edit) });

// A suspended one is resumed, and the other way round; what was only wished is taken back.
export function toggled(edit: Edit): Edit {
  const { use, ...rest } = edit;
  if (use !== undefined) return rest;
  return { ...rest, use: edit.base.use === Use.SUSPENDED ? 'resumed' : 'suspended' };
}

// The same wishes for what is there now.
export const laidOn = (edit: Edit, base: LinkPoint): Edit => {
  const { use, ...rest } = edit;
  const isDone = use === undefined || (use === 'suspended') === (base.use === Use.SUSPENDED);
  return { ...rest, base, ...(!isDone && { use }) };
};

// `etag`: of what is suspended, resumed or deleted; an update has its own.
export const changeOf = (change: GraphChange['change'], etag = ''): GraphChange => create(GraphChangeSchema, { change, etag });

// What it updates, as in UpdateLinkPointRequest.
function masked(edit: Edit): string[] {
  const { base, kind = base.kind, state = base.state, pinned } = edit;
  const paths: string[] = [];
  if (!isIdle({ base, isNew: false, anchors: edit.anchors })) paths.push('anchors');
  if (base.directionMap !== '' && !anchorsOf(edit).has(base.directionMap)) paths.push('direction_map');
  if (kind !== base.kind) paths.push('kind');
  if (state !== base.state) paths.push('state', 'state_valid_until');
  if (pinned !== undefined && (pinned !== (base.pinned ?? false) || isPlaced(edit))) paths.push('pinned');
  return paths;
}

// The first change of a link point has the etag of what the person saw.
function changesOfOne(name: string, edit: Edit): GraphChange[] {
  const { base: { etag }, isNew, isDeleted, use } = edit;
  if (isNew) return [changeOf({ case: 'created', value: wantedOf(edit) })];
  if (isDeleted) return [changeOf({ case: 'deleted', value: name }, etag)];
  const paths = masked(edit);
  const changes: GraphChange[] = [];
  if (paths.length > 0) changes.push(create(GraphChangeSchema, { change: { case: 'updated', value: wantedOf(edit) }, updateMask: { paths } }));
  if (use !== undefined) changes.push(changeOf({ case: use, value: name }, paths.length > 0 ? '' : etag));
  return changes;
}

export const changesOf = (draft: Draft): GraphChange[] => [...draft].flatMap(([name, edit]) => (isIdle(edit) ? [] : changesOfOne(name, edit)));
