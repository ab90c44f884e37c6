// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/geometry/pose2.h"
#include "core/prior/alignment/wall_faces.h"
#include "core/sensor/scan_pairing.h"
#include "core/slam/slam_options.h"

namespace enfilade::prior {

// Where a robot was in a plan.
struct PlanTrack {
  std::vector<Pose2> T_map_robot;  // of each scan
  double matched_share = 0;        // of the scans' hits, near walls of the plan; the mean over the scans
};

// Tracks a robot through a plan by the scans and its odometry, from a place that is known to about half a metre: an
// extended Kalman filter, then its smoother (H. E. Rauch, F. Tung, C. T. Striebel, "Maximum likelihood estimates of
// linear dynamic systems", 1965). Each scan is searched for in the window of its prediction (slam::SearchPose), and its
// pose refined there (slam::MatchToField). As plans are drawn, walls may be off by some decimetres, and all hits on one
// wall are off together: a scan counts as few beams. `faces`: the plan's in the map's frame.
PlanTrack TrackInPlan(const std::vector<WallFace>& faces, const std::vector<sensor::PairedScan>& scans,
                      const Pose2& T_map_first, const slam::SlamOptions& options);

}  // namespace enfilade::prior
