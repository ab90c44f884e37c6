// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
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

// How a wall that a map has seen fits (WallSighting).
struct SightingUse {
  bool is_part = false;  // the map and the plan are part of the graph
  bool used = false;
  double across = 0.0;  // m: where the wall lies, to the left of where it was seen
  double turn = 0.0;    // rad
  double chi2 = 0.0;    // 2 degrees of freedom

  friend bool operator==(const SightingUse&, const SightingUse&) = default;
};

// How a shaft of a plan fits to the same shaft of a plan of another level (SameShafts).
struct ShaftUse {
  std::string name = {};
  PriorMapId other = {};
  bool used = false;      // it ties the two plans; else it contradicts the others
  double distance = 0.0;  // m, between the middles of the two
  double chi2 = 0.0;      // 3 degrees of freedom

  friend bool operator==(const ShaftUse&, const ShaftUse&) = default;
};

// What the optimisation has made of a floor plan (PlanTies).
struct PlanUse {
  PriorMapId plan = {};
  int used = 0;          // walls that maps have seen: sightings that count
  int switched_off = 0;  // ... that contradict the others
  // Why the plan contradicts what robots have measured; it then has no influence. Empty: it does not.
  std::string contradiction = {};
  std::vector<SightingUse> sightings = {};  // of each of the ties; empty: the plan is not part of the graph
  std::vector<ShaftUse> shafts = {};        // that it shares with other plans of the graph

  friend bool operator==(const PlanUse&, const PlanUse&) = default;
};

// What a plan contributes to the covariance of a map's pose: (x, y, yaw) of T_world_map, m^2, m rad, rad^2.
struct PlanShare {
  PriorMapId plan = {};
  // The number in the plan of a wall that the map has seen; -1: everything else, that is how the plan is drawn, and
  // what other maps have seen of it.
  int wall = -1;
  // Not empty: the share of the shaft with this name, which ties the plan to those of higher levels.
  std::string shaft = {};
  Eigen::Matrix3d share = Eigen::Matrix3d::Zero();
};

// The poses of the maps after an optimisation.
struct SolvedGraph {
  std::int64_t graph_version = 0;  // of the input
  MapId root = {};
  // T_world_map with its covariance relative to the root, whose own is zero. Without maps that neither a chain nor a
  // plan connects to the root.
  std::unordered_map<MapId, PoseWithCovariance> map_poses = {};
  std::vector<SwitchedOff> switched_off = {};  // sorted by id
  std::vector<MapId> disconnected = {};        // from the root; sorted by id
  std::vector<PlanUse> plans = {};             // of each plan that the graph has, by id
  std::vector<PlanShare> plan_shares =
      {};  // of GraphOptimizationOptions::shares_of; by plan, then by wall, shafts last

  double chi2_before = 0.0;  // at the initial poses, over the link points in use afterwards
  double chi2_after = 0.0;
  int degrees_of_freedom = 0;  // of chi2_after, if the covariances describe the noise
  int iterations = 0;
  bool converged = false;
};

}  // namespace enfilade::graph
