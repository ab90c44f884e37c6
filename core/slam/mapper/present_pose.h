// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "core/base/time.h"
#include "core/geometry/pose2.h"
#include "core/slam/slam_options.h"

namespace enfilade::slam {

struct MapperState;

// Where the robot was at a scan, by the current estimate.
struct PresentPose {
  TimeNs time = 0;  // of the scan
  // The covariance is relative to the first keyframe, or to the existing map if mapping continues one.
  PoseWithCovariance T_map_robot;
  bool lost = false;  // the last good match is too long ago
};

// The pose at the last used scan; empty before the first. The covariance starts from that of the last keyframe in the
// last solution of the graph (before the first solution: from zero at the first submap), and adds what was measured
// from there along the submaps.
std::optional<PresentPose> FindPresentPose(const MapperState& state, const QualityOptions& options);

}  // namespace enfilade::slam
