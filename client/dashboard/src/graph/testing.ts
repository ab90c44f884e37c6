// SPDX-License-Identifier: Apache-2.0
// Link points that tests draw up.
import { create, fromJson, type JsonValue } from '@bufbuild/protobuf';
import { LinkPointSchema, type LinkPoint } from '../gen/enfilade/v1/link_point_pb';

export const scanner = [0.0015, 0, 0, 0, 0.0015, 0, 0, 0, 0.0015];

export const site = 'sites/s';
export const mapName = (id: string) => `${site}/maps/${id}`;
export const linkPointName = (id: string) => `${site}/linkPoints/${id}`;
export const titleOf = (name: string) => name.slice(name.lastIndexOf('/') + 1);

// `places`: [x, y, yaw] by the ids of maps.
export function linkPoint(id: string, places: Record<string, [number, number, number]>, rest: Record<string, JsonValue> = {}): LinkPoint {
  const anchors = Object.entries(places).map(([map, [x, y, yaw]]) => ({ map: mapName(map), poseMapPlace: { pose: { x, y, yaw }, covariance: scanner } }));
  return create(LinkPointSchema, fromJson(LinkPointSchema, { name: linkPointName(id), kind: 'KIND_DOOR', state: 'STATE_OPEN', use: 'USE_USED', etag: '"5"', anchors, ...rest }));
}
