// SPDX-License-Identifier: Apache-2.0
import { create } from '@bufbuild/protobuf';
import { expect, test } from 'vitest';
import { AlignMapsResponseSchema } from '../gen/enfilade/v1/graph_service_pb';
import { chained, relative, reversed, samePose } from '../scene/se2';
import { anchorsOfFit, covarianceOfJoint, jacobiansOf, linkPointOfFit } from './alignment';
import { placeOf } from './draft';
import { mapName } from './testing';

const pose = { x: 3.2, y: -1.5, yaw: 2.1 };
const covariance = [0.04, 0.01, 0.002, 0.01, 0.09, -0.003, 0.002, -0.003, 0.0025];

test('two anchors at one place say of the maps what the fit says, its covariance included', () => {
  for (const place of [{ x: 0, y: 0 }, { x: 40, y: -25 }, { x: -3, y: 7 }]) {
    const [a, b] = anchorsOfFit(pose, covariance, place);
    expect(samePose(chained(a.pose, reversed(b.pose)), pose, 1e-9)).toBe(true);
    covarianceOfJoint(a, b).forEach((value, i) => expect(value).toBeCloseTo(covariance[i]!, 9));
    for (const { covariance: c } of [a, b]) expect([c[3], c[6], c[7]]).toEqual([c[1], c[2], c[5]]);
  }
});

test('the derivatives are those of finite differences', () => {
  const a = { x: 5, y: 2, yaw: 0.7 };
  const b = { x: -4, y: 3, yaw: -1.2 };
  const step = 1e-6;
  const vector = (p: { x: number; y: number; yaw: number }) => [p.x, p.y, p.yaw];
  const joint = (x: typeof a, y: typeof b) => vector(chained(x, reversed(y)));
  const analytic = jacobiansOf(a, b);
  for (const [i, key] of (['x', 'y', 'yaw'] as const).entries()) {
    const byA = joint({ ...a, [key]: a[key] + step }, b).map((value, row) => (value - joint({ ...a, [key]: a[key] - step }, b)[row]!) / (2 * step));
    const byB = joint(a, { ...b, [key]: b[key] + step }).map((value, row) => (value - joint(a, { ...b, [key]: b[key] - step })[row]!) / (2 * step));
    byA.forEach((value, row) => expect(analytic[0][3 * row + i]).toBeCloseTo(value, 6));
    byB.forEach((value, row) => expect(analytic[1][3 * row + i]).toBeCloseTo(value, 6));
  }
});

test('a fit becomes an opening at the place in the overlap; a refusal without a place becomes nothing', () => {
  const answer = create(AlignMapsResponseSchema, { accepted: true, poseAB: { pose, covariance }, placeA: { x: 6, y: 1 } });
  const made = linkPointOfFit('sites/s/linkPoints/n', mapName('a'), mapName('b'), answer)!;
  const [a, b] = made.anchors.map(placeOf);
  expect(made.anchors.map(({ map }) => map)).toEqual([mapName('a'), mapName('b')]);
  expect(a!.pose).toEqual({ x: 6, y: 1, yaw: 0 });
  expect(samePose(b!.pose, relative(pose, { x: 6, y: 1, yaw: 0 }), 1e-12)).toBe(true);
  expect(linkPointOfFit('sites/s/linkPoints/n', mapName('a'), mapName('b'), create(AlignMapsResponseSchema, { reason: 'they do not overlap' }))).toBeUndefined();
});
