// SPDX-License-Identifier: Apache-2.0
// A link point out of the fit of two maps.
import { create } from '@bufbuild/protobuf';
import type { AlignMapsResponse } from '../gen/enfilade/v1/graph_service_pb';
import { LinkPointSchema, LinkPoint_Kind as Kind, type LinkPoint } from '../gen/enfilade/v1/link_point_pb';
import type { Point, Pose } from '../scene/camera';
import { relative, placedBy } from '../scene/se2';
import { anchorOf, type AnchorPlace } from './draft';
import { carried, scaled, sum } from './matrix3';

// T_a_b = A B^-1 with A and B the poses of one place in the maps a and b. Its derivatives by A and B, in (x, y, yaw).
export function jacobiansOf(a: Pose, b: Pose): [byA: number[], byB: number[]] {
  const turn = a.yaw - b.yaw;
  const [cos, sin] = [Math.cos(turn), Math.sin(turn)];
  // B's position, turned into a.
  const [vx, vy] = [cos * b.x - sin * b.y, sin * b.x + cos * b.y];
  return [
    [1, 0, vy, 0, 1, -vx, 0, 0, 1],
    [-cos, sin, -vy, -sin, -cos, vx, 0, 0, -1],
  ];
}

// Of matrices of the forms above.
function inverseOf([a = 0, b = 0, p = 0, c = 0, d = 0, q = 0, , , e = 0]: readonly number[]): number[] {
  const det = a * d - b * c;
  const [ia, ib, ic, id] = [d / det, -b / det, -c / det, a / det];
  return [ia, ib, -(ia * p + ib * q) / e, ic, id, -(ic * p + id * q) / e, 0, 0, 1 / e];
}

// The covariance of T_a_b that two anchors make.
export function covarianceOfJoint(a: AnchorPlace, b: AnchorPlace): number[] {
  const [byA, byB] = jacobiansOf(a.pose, b.pose);
  return sum(carried(byA, a.covariance), carried(byB, b.covariance));
}

// Anchors at `place` (in the frame of a) that say of the maps exactly what the fit says: half of its covariance is that of
// each anchor.
export function anchorsOfFit(poseAB: Pose, covariance: readonly number[], place: Point): [a: AnchorPlace, b: AnchorPlace] {
  const a: Pose = { ...place, yaw: 0 };
  const b = relative(poseAB, a);
  const [byA, byB] = jacobiansOf(a, b);
  const half = scaled(covariance, 0.5);
  return [
    { pose: a, covariance: carried(inverseOf(byA), half) },
    { pose: b, covariance: carried(inverseOf(byB), half) },
  ];
}

// Undefined: the answer has no place.
export function linkPointOfFit(name: string, mapA: string, mapB: string, { poseAB, placeA }: AlignMapsResponse): LinkPoint | undefined {
  if (!poseAB?.pose || poseAB.covariance.length !== 9) return undefined;
  const { x, y, yaw } = poseAB.pose;
  const place = placeA ? { x: placeA.x, y: placeA.y } : placedBy({ x, y, yaw }, { x: 0, y: 0 });
  const [a, b] = anchorsOfFit({ x, y, yaw }, poseAB.covariance, place);
  return create(LinkPointSchema, { name, kind: Kind.OPENING, anchors: [anchorOf(mapA, a), anchorOf(mapB, b)] });
}
