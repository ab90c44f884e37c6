// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/time.h"
#include "core/geometry/pose2.h"
#include "core/prior/localization/plan_field.h"
#include "core/prior/localization/plan_localizer.h"
#include "core/prior/localization/plan_state.h"

namespace enfilade::prior {

// Where a submap lies in a plan.
struct TrackedSubmap {
  std::int64_t submap = 0;
  bool accepted = false;
  PlanState state;  // of the submap's frame; scale, stretch and side are those of the guess
  // Of (x, y, yaw), 1/m^2 and so on, along the plan frame's axes in metres: nearly singular in a corridor.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  double matched = 0;  // share of its points that are on the plan's walls
};

// Moves a submap onto the plan's walls, as large as the guess says (slam::MatchToField). `points`: of its walls, in its
// frame, m. Accepted if half of them are on walls.
TrackedSubmap TrackSubmap(const PlanField& field, const std::vector<Eigen::Vector2d>& points, const PlanState& guess,
                          const PlanLocalizerOptions& options);

struct DriveSubmap {
  std::int64_t id = 0;
  Pose2 T_map_submap;
  std::vector<Eigen::Vector2d> points;  // of its walls, in its frame, m
};
struct DriveLook {
  PlanLook look;
  std::int64_t submap = 0;  // that the robot was in
};
// A drive as SLAM has mapped it.
struct MappedDrive {
  std::vector<TimeNs> times;         // of each look
  std::vector<DriveLook> looks;      // the keyframes with their scans, in order of time
  std::vector<DriveSubmap> submaps;  // by id
};

struct PlanDrive {
  std::vector<PlanPosterior> steps;  // of each look
  std::vector<TrackedSubmap> submaps;
  std::vector<PlanParticle> particles;  // after the last look
};

// Follows a drive through a plan. Whenever a submap is finished and one mode is confident, the submap is moved onto the
// plan's walls, and where it lies bounds where the robot may be (PlanLocalizer::Gate). Errors: keep_going's.
absl::StatusOr<PlanDrive> LocateDrive(const PlanField& field, const std::vector<ControlPair>& pairs,
                                      const MappedDrive& mapped, const PlanLocalizerOptions& options,
                                      const KeepGoing& keep_going = {});

}  // namespace enfilade::prior
