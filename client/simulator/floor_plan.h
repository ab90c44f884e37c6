#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace enfilade::simulator {

// Walls and a route, drawn as text: '#' is a cell of wall, a letter a to z a point of the route (driven in the order of
// the alphabet) on free ground, anything else free ground. Frame: metres, x to the right, y up, the origin at the lower
// left corner of the drawing. Outside of the drawing is wall.
class FloorPlan {
 public:
  // INVALID_ARGUMENT: no rows, a cell size that is not positive, fewer than two points in the route, a letter twice.
  static absl::StatusOr<FloorPlan> Parse(std::string_view drawing, double cell_size);

  bool IsWall(int column, int row) const;  // row 0 is the lowest
  bool IsWallAt(const Eigen::Vector2d& point) const;

  // How far from `from` along the unit vector `direction` the nearest wall is, m; `limit` where there is none within
  // it. Exact traversal of the cells (Amanatides, Woo 1987).
  double DistanceToWall(const Eigen::Vector2d& from, const Eigen::Vector2d& direction, double limit) const;

  // The middles of the route's cells.
  const std::vector<Eigen::Vector2d>& route() const { return route_; }

 private:
  FloorPlan(std::vector<std::string> rows, double cell_size) : rows_(std::move(rows)), cell_size_(cell_size) {}

  std::vector<std::string> rows_;  // the highest first, as drawn
  double cell_size_;               // m
  std::vector<Eigen::Vector2d> route_;
};

// Three rooms in a row, joined by doors to each other and to a corridor along them; the route goes round through all of
// it. 19 m x 10.5 m.
const FloorPlan& EnfiladePlan();

}  // namespace enfilade::simulator
