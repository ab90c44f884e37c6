// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "core/geometry/pose2.h"

namespace enfilade::testing {

struct TimedPose {
  double time = 0.0;  // s
  Pose2 pose;
};

// Lines "t x y yaw" (s, m, rad), with spaces or commas, sorted by time; other lines are skipped. Throws if there are
// none.
std::vector<TimedPose> ReadTrajectory(const std::filesystem::path& file);

// The pose of time2 in the frame of that of time1.
struct Relation {
  double time1 = 0.0;
  double time2 = 0.0;
  Pose2 T_1_2;
};

// Lines "t1 t2 x y z roll pitch yaw". Throws if there are none.
std::vector<Relation> ReadRelations(const std::filesystem::path& file);

struct TrajectoryError {
  double metres = 0.0;
  double degrees = 0.0;
  int used = 0;     // relations or poses
  int skipped = 0;  // for which the trajectory has no pose within 0.5 s
};

// The mean error over relations (Kuemmerle et al. 2009: On measuring the accuracy of SLAM algorithms).
TrajectoryError ErrorByRelations(const std::vector<TimedPose>& trajectory, const std::vector<Relation>& relations);

// The root mean square of the error of the trajectory's positions and yaws, at the reference's times, after the rigid
// transform that fits the positions best (absolute trajectory error).
TrajectoryError ErrorByReference(const std::vector<TimedPose>& trajectory, const std::vector<TimedPose>& reference);

}  // namespace enfilade::testing
