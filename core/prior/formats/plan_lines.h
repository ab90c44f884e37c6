// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "core/prior/plan/plan_graph.h"

namespace enfilade::prior {

// Which parts of a drawing are read, by the names of their layers: patterns with * and ?, upper and lower case alike.
// Without patterns, everything is.
bool IsWantedLayer(const std::vector<std::string>& patterns, std::string_view layer);

// Collects the lines of a vector drawing as walls.
class PlanLines {
 public:
  // `T` maps the drawing's coordinates to the sheet. Lines without length are left out.
  void Add(const Eigen::Affine2d& T, const std::vector<Eigen::Vector2d>& points, bool closed, double thickness);

  // RESOURCE_EXHAUSTED: more walls than kMostWalls. INVALID_ARGUMENT: a coordinate that is not finite.
  const absl::Status& status() const { return status_; }
  PlanGraph TakePlan() { return std::move(plan_); }

 private:
  PlanGraph plan_;
  absl::Status status_;
};

// Chords of an ellipse's arc in its own frame, from angle `from` through `sweep` (rad), both ends among them. They stay
// within `sagitta` of the arc, if that is positive; else each spans 7.5 degrees.
std::vector<Eigen::Vector2d> ChordsOf(const Eigen::Vector2d& radii, double from, double sweep, double sagitta);

}  // namespace enfilade::prior
