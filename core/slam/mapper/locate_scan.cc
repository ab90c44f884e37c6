// SPDX-License-Identifier: Apache-2.0
#include "core/slam/mapper/locate_scan.h"

#include <Eigen/Dense>

#include "core/slam/mapper/policies.h"
#include "core/slam/matching/motion_model.h"

namespace enfilade::slam {
namespace {

constexpr double kExact = 1e-3;  // m, rad

}  // namespace

LocatedScan LocateFirstScan(const sensor::PairedScan& scan) {
  LocatedScan located;
  located.track.T_odom_robot = scan.T_odom_robot;
  located.track.time = scan.scan.time;
  located.track.matched_at = scan.scan.time;
  located.information = InformationOf(kExact, kExact);
  return located;
}

LocatedScan LocateScan(const Track& last, const sensor::PairedScan& scan, const grid::ScanRays& rays,
                       const LocalMap& map, const SlamOptions& options) {
  LocatedScan located;
  Track& track = located.track = last;
  const double seconds = ToSeconds(scan.scan.time - last.time);
  const PredictedMotion motion =
      PredictMotion(last.T_odom_robot, scan.T_odom_robot, last.last_step, seconds, options.motion);
  Pose2 next = last.T_submap_robot * motion.T_last_now;
  located.information = InformationOf(motion.sigma_translation, motion.sigma_yaw);
  if (options.match_scans) {
    const auto match_from = [&](const PredictedMotion& expected) {
      return MatchLocally(map, rays.hits, last.T_submap_robot, expected, options.local);
    };
    LocalMatch match = match_from(motion);
    if (!match.good && motion.by_odometry) {  // without odometry
      const LocalMatch other = match_from(PredictMotion({}, {}, last.last_step, seconds, options.motion));
      const bool may_be_right = match.agreement.contradicted_share == 0.0;
      if (IsSure(other, options.local) && (!may_be_right || IsUnmistakable(other))) match = other;
    }
    if (match.good) {
      next = match.match.T_submap_robot;
      track.matched_at = scan.scan.time;
      located.residual = match.match.residual;
    }
    located.information += match.match.information;
    located.matched_share = match.agreement.matched_share;
    located.may_insert = MayInsert(match, options.local);
    track.quality = Updated(last.quality, match, options.local);
  }
  track.last_step = Step{Between(last.T_submap_robot, next), seconds};
  track.length_since_keyframe += track.last_step->T_from_to.translation().norm();
  track.T_submap_robot = next;
  track.T_odom_robot = scan.T_odom_robot;
  track.time = scan.scan.time;
  return located;
}

PoseWithCovariance LocateAtEntry(const ExistingMapEntry& entry, const sensor::PairedScan& scan,
                                 const grid::ScanRays& rays, const SlamOptions& options) {
  const PoseWithCovariance by_odometry = PoseAtScan(entry, scan.T_odom_robot, options);
  if (!entry.seen || !entry.T_odom_robot || !options.match_scans) return by_odometry;
  SubmapGrid grid(options.resolution, options.occupancy);
  if (!grid.Insert(Pose2{}, *entry.seen).ok()) return by_odometry;
  LocalFields fields(options.resolution, options.local);
  fields.Rebuild(grid);
  Track at_entry;
  at_entry.T_odom_robot = entry.T_odom_robot;
  at_entry.time = scan.scan.time;
  const LocatedScan located = LocateScan(at_entry, scan, rays, {grid, fields}, options);
  if (!located.residual) return by_odometry;
  return Compose(PoseAtScan(entry, entry.T_odom_robot, options),
                 {located.track.T_submap_robot, located.information.inverse()});
}

}  // namespace enfilade::slam
