// SPDX-License-Identifier: Apache-2.0
import type { GlobalPose } from '../../gen/enfilade/v1/graph_pb';
import { titleOf } from '../../live/objects';
import type { LiveSite } from '../../live/site';
import type { Point } from '../../scene/camera';

export interface Share {
  title: string;
  // The resource that it comes from.
  name: string;
  // Position variance, m^2.
  variance: number;
  // Of the whole, 0 to 1.
  part: number;
}

const variance = (covariance: number[]) => (covariance[0] ?? 0) + (covariance[4] ?? 0);

// What the uncertainty of a global pose is made of, from the root to the robot. The parts add up to 1.
export function sharesOf(site: LiveSite, pose: GlobalPose): Share[] {
  const shares: Omit<Share, 'part'>[] = [];
  const base = titleOf(site, pose.baseMap);
  shares.push({
    title: pose.baseMap === site.rootMap ? `${base}: the root` : `${base}: as optimised`, name: pose.baseMap, variance: variance(pose.baseShare),
  });
  for (const hop of pose.hops) {
    shares.push({ title: `${titleOf(site, hop.linkPoint)}, into ${titleOf(site, hop.toMap)}`, name: hop.linkPoint, variance: variance(hop.share) });
  }
  shares.push({ title: pose.robot === '' ? 'The given pose' : "The robot's own report", name: pose.robot, variance: variance(pose.robotShare) });
  const total = shares.reduce((sum, share) => sum + share.variance, 0);
  return shares.map((share) => ({ ...share, part: total > 0 ? share.variance / total : 0 }));
}

// The places that the chain passes, for a line on the map; empty if the pose is not known in the world.
export function chainOf(site: LiveSite, pose: GlobalPose): Point[] {
  const end = pose.poseWorldRobot?.pose;
  if (!end) return [];
  const points: Point[] = [];
  if (pose.poseWorldBase?.pose) points.push(pose.poseWorldBase.pose);
  for (const { linkPoint } of pose.hops) {
    const place = site.linkPoints.get(linkPoint)?.poseWorldPlace?.pose;
    if (place) points.push(place);
  }
  points.push(end);
  return points.map(({ x, y }) => ({ x, y }));
}
