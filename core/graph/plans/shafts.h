// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/pose2.h"
#include "core/graph/plans/plan_ties.h"

namespace enfilade::graph {

// How far a corner of a shaft may lie from the same corner a floor above or below, m, in each axis.
constexpr double kShaftSigma = 0.1;

// A shaft that two plans have in common: its index in PlanTies::shafts of each.
struct SameShaft {
  std::size_t a = 0;
  std::size_t b = 0;
};

// The shafts that are the same in two plans, in the order of a's. They have one name, which no other shaft of either
// plan has, and one kind; they have equally many corners, and fit onto each other turned and shifted: chi-squared of
// the corners, by how both plans are drawn, is within its 0.99 quantile.
std::vector<SameShaft> SameShafts(const PlanTies& a, const PlanTies& b);

// The rigid transform that moves points onto others by least squares (S. Umeyama, 1991). Both have the same size, at
// least 2.
Pose2 FitRigid(const std::vector<Eigen::Vector2d>& to, const std::vector<Eigen::Vector2d>& from);

// The outline of b, in a's frame, begun at the corner that lies best on a's first one if corners follow each other in
// the same order: corner i of the result is that which belongs to corner i of a. Of equal size.
std::vector<Eigen::Vector2d> InOrderOf(const std::vector<Eigen::Vector2d>& a, std::vector<Eigen::Vector2d> b);

// A plan that has a place in the world.
struct PlacedPlan {
  const PlanInGraph* plan = nullptr;
  Pose2 T_world_plan;
};

// Where a plan lies by the shafts that it shares with plans of other levels.
struct ShaftPlacement {
  std::optional<Pose2> T_world_plan = std::nullopt;
  std::vector<std::string> shafts = {};  // names of those that it rests on, in order
  std::string reason = {};               // why there is no place; empty: there is one
};

// By two shafts and more, each as the placed plan of the nearest level has it. A single one says too little: most
// shafts look the same after a quarter or half turn. There is no place if the shafts lie otherwise to each other than
// above or below, or are turned otherwise (chi-squared of their middles, and of their corners around these, beyond its
// 0.99 quantile, by how the plans are drawn), or so near to each other that three standard deviations of the turn are
// more than 45 degrees.
ShaftPlacement PlaceByShafts(const PlanTies& ties, int level, const std::vector<PlacedPlan>& placed);

}  // namespace enfilade::graph
