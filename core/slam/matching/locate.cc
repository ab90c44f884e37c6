// SPDX-License-Identifier: Apache-2.0
#include "core/slam/matching/locate.h"

#include "core/slam/mapper/motion_model.h"
#include "core/slam/mapper/policies.h"

namespace enfilade::slam {
Place FirstPlace(const sensor::PairedScan& scan, const MotionOptions& options) {
  Place place;
  place.track.T_odom_robot = scan.T_odom_robot;
  place.track.time = scan.scan.time;
  place.track.matched_at = scan.scan.time;
  place.information = InformationOf(options.translation_floor, options.yaw_floor);
  return place;
}

Place Locate(const Track& last, const sensor::PairedScan& scan, const grid::ScanRays& rays, const SubmapGrid& grid,
             const LocalFields& fields, const SlamOptions& options) {
  Place place;
  Track& track = place.track = last;
  const double seconds = ToSeconds(scan.scan.time - last.time);
  const PredictedMotion motion =
      PredictMotion(last.T_odom_robot, scan.T_odom_robot, last.last_step, seconds, options.motion);
  Pose2 next = last.T_submap_robot * motion.T_last_now;
  place.information = InformationOf(motion.sigma_translation, motion.sigma_yaw);
  if (options.match_scans) {
    const auto match_from = [&](const PredictedMotion& expected) {
      return MatchLocally(grid, fields, rays.hits, last.T_submap_robot, expected, options.local);
    };
    LocalMatch match = match_from(motion);
    if (!match.good && motion.by_odometry) {  // wheels slip and jump: what do the scans alone say?
      const LocalMatch other = match_from(PredictMotion({}, {}, last.last_step, seconds, options.motion));
      const bool may_be_right = match.agreement.contradicted_share == 0.0;
      if (IsSure(other, options.local) && (!may_be_right || IsUnmistakable(other))) match = other;
    }
    if (match.good) {
      next = match.match.T_submap_robot;
      track.matched_at = scan.scan.time;
    }
    place.information += match.match.information;
    place.matched_share = match.agreement.matched_share;
    place.may_insert = MayInsert(match, options.local);
    track.quality = Updated(last.quality, match, options.local);
  }
  track.last_step = Step{Between(last.T_submap_robot, next), seconds};
  track.length_since_keyframe += track.last_step->T_from_to.translation().norm();
  track.T_submap_robot = next;
  track.T_odom_robot = scan.T_odom_robot;
  track.time = scan.scan.time;
  return place;
}

}  // namespace enfilade::slam
