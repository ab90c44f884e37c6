// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "core/base/ids.h"
#include "core/geometry/pose2.h"

namespace enfilade::graph {

// A link point that the optimisation does not use because it contradicts the others.
struct SwitchedOff {
  LinkPointId link_point = {};
  double chi2 = 0.0;  // at the final poses
  double gate = 0.0;  // limit of chi2

  friend bool operator==(const SwitchedOff&, const SwitchedOff&) = default;
};

// The poses of the maps after an optimisation.
struct SolvedGraph {
  std::int64_t graph_version = 0;  // of the input
  MapId root = {};
  // T_world_map with its covariance relative to the root, whose own is zero. Without maps that no chain connects to the
  // root.
  std::unordered_map<MapId, PoseWithCovariance> map_poses = {};
  std::vector<SwitchedOff> switched_off = {};  // sorted by id
  std::vector<MapId> disconnected = {};        // from the root; sorted by id

  double chi2_before = 0.0;  // at the initial poses, over the link points in use afterwards
  double chi2_after = 0.0;
  int degrees_of_freedom = 0;  // of chi2_after, if the covariances describe the noise
  int iterations = 0;
  bool converged = false;
};

}  // namespace enfilade::graph
