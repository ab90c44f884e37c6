// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "core/base/ids.h"
#include "core/geometry/pose2.h"

namespace enfilade::graph {

// A link point that the optimisation does not use: it contradicts the others.
struct SwitchedOff {
  LinkPointId link_point = {};
  double chi2 = 0.0;  // of the final poses
  double gate = 0.0;  // what chi2 may be

  friend bool operator==(const SwitchedOff&, const SwitchedOff&) = default;
};

// Where the maps lie after an optimisation.
struct SolvedGraph {
  std::int64_t graph_version = 0;  // that it was made from
  MapId root = {};
  // T_world_map with its covariance relative to the root, whose own is zero. Maps that no chain joins to the root are
  // not in it.
  std::unordered_map<MapId, PoseWithCovariance> map_poses = {};
  std::vector<SwitchedOff> switched_off = {};  // by id
  std::vector<MapId> disconnected = {};        // from the root; by id

  double chi2_before = 0.0;  // over the link points in use after it, at the poses that it began with
  double chi2_after = 0.0;
  int degrees_of_freedom = 0;  // of chi2_after, if noise is as the covariances say
  int iterations = 0;
  bool converged = false;
};

}  // namespace enfilade::graph
