// SPDX-License-Identifier: Apache-2.0
// The walls of one level of a floor plan, as a graph.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace enfilade::prior {

// The sheet frame: that of a picture or drawing as people see it. The origin is the centre of the top left pixel, x
// points right and y down. The unit is a pixel, or the drawing's own unit; files whose y points up are turned over when
// they are read. All points and lengths below are in it.

// Where walls end, bend or meet.
struct PlanCorner {
  Eigen::Vector2d point = Eigen::Vector2d::Zero();
};

// A straight piece of wall along its centre line.
struct PlanWall {
  int from = 0;  // index of a corner
  int to = 0;
  double thickness = 0;   // 0: unknown, or drawn as a line
  double confidence = 1;  // in (0, 1]: that it is a wall, by how it is drawn
};

// The opening between its two jambs.
struct PlanDoor {
  Eigen::Vector2d from = Eigen::Vector2d::Zero();
  Eigen::Vector2d to = Eigen::Vector2d::Zero();
  double confidence = 1;
};

// A closed outline, its first point not repeated.
struct PlanRoom {
  std::vector<Eigen::Vector2d> outline;
  std::string name;
};

enum class ShaftKind { kLift, kStairs };

// What goes through several levels.
struct PlanShaft {
  ShaftKind kind = ShaftKind::kLift;
  std::vector<Eigen::Vector2d> outline;
  std::string name;
};

struct PlanGraph {
  std::vector<PlanCorner> corners;
  std::vector<PlanWall> walls;
  std::vector<PlanDoor> doors;
  std::vector<PlanRoom> rooms;
  std::vector<PlanShaft> shafts;
  // m, by the file's own units, dimensions or measurements; not set: unknown.
  std::optional<double> metres_per_unit = std::nullopt;
  // Set if the picture was the photo of a page: from pixels of the photo to the sheet frame, that of the page as if
  // seen from straight above.
  std::optional<Eigen::Matrix3d> H_sheet_photo = std::nullopt;
};

// Larger buildings are errors of scale.
constexpr double kLargestPlan = 20'000;  // m
constexpr double kLargestCoordinate = 1e12;

// A point that somebody has picked in the plan's file, in the sheet frame: of a photo it is in the photo's pixels.
Eigen::Vector2d ToSheet(const PlanGraph& plan, const Eigen::Vector2d& picked);

double LengthOf(const PlanGraph& plan, const PlanWall& wall);
double WallLength(const PlanGraph& plan);  // of all walls
double DiagonalOf(const PlanGraph& plan);  // of the box around its corners; 0: it has none

// Fails with INVALID_ARGUMENT, naming the element: an index that no corner has, a wall without length, a number that is
// not finite, a corner beyond kLargestCoordinate, a homography that has no inverse, a confidence outside (0, 1], an
// outline of fewer than three points, a scale by which the plan is larger than kLargestPlan.
absl::Status Validate(const PlanGraph& plan);

}  // namespace enfilade::prior
