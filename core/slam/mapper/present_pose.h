// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "core/base/time.h"
#include "core/geometry/pose2.h"
#include "core/slam/slam_options.h"

namespace enfilade::slam {

struct MapperState;

// Where the robot was at a scan, by the present estimate.
struct PresentPose {
  TimeNs time = 0;  // of the scan
  // With the covariance against the map: the first keyframe, or the old map that mapping goes on in.
  PoseWithCovariance T_map_robot;
  bool lost = false;  // the last good match is too long ago
};

// At the last scan. The covariance is what the last solution of the graph says of a keyframe, and from there along the
// submaps what was measured since; before the first solution, from the map's beginning on.
std::optional<PresentPose> FindPresentPose(const MapperState& state, const QualityOptions& options);

}  // namespace enfilade::slam
