// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <functional>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/geometry/pose2.h"
#include "core/localization/localization_options.h"
#include "core/localization/searchable_map.h"

namespace enfilade::localization {

// Asked now and then during a search. An error ends the search and becomes its result: CANCELLED, DEADLINE_EXCEEDED.
using KeepGoing = std::function<absl::Status()>;

// The part of the map to search.
struct SearchArea {
  Eigen::Vector2d centre;
  double radius = 0.0;      // m
  double yaw = 0.0;         // rad, the headings to search:
  double half_yaw = M_PI;   // within so much of `yaw`
  bool off_ground = false;  // also where no robot can stand
};

struct FoundPose {
  Pose2 T_map_robot;
  double score = 0.0;  // mean likelihood of the points, 0..1
};

struct FoundPoses {
  std::vector<FoundPose> poses;  // the best first
  bool complete = true;          // false: there are more, or may be; the search was given up
};

// All places of the map where the points (robot's frame, m) fit: the local maxima of their mean likelihood over all
// positions (on known ground unless area.off_ground) and headings, down to options.min_score and to min_relative_score
// of the best. Branch and bound as in SearchPose (Olson 2015, Hess et al. 2016), best first, so that it finds many
// places in order.
absl::StatusOr<FoundPoses> FindPoses(const SearchableMap& map, const std::vector<Eigen::Vector2d>& points,
                                     const std::optional<SearchArea>& area, const LocalizationOptions& options,
                                     const KeepGoing& keep_going);

}  // namespace enfilade::localization
