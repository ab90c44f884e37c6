// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/geometry/pose2.h"

namespace enfilade::prior {

// The floors, doors and lifts of a building.yaml of Open-RMF's traffic editor. Each level has its own frame: metres,
// origin in the upper left corner of its drawing, x to the right and y up in the drawing.

struct BuildingDoor {
  std::string name;
  Pose2 T_level_door;  // the middle of its opening, x through the door
  double width = 0.0;  // m
};

struct BuildingWall {
  Eigen::Vector2d a;  // m
  Eigen::Vector2d b;
};

struct BuildingLevel {
  std::string name;
  int level = 0;  // 0: the lowest that is not below ground
  std::vector<Eigen::Vector2d>
      outline;  // m: the convex hull of its floors, or of its walls if it has no floors; may be empty
  std::vector<BuildingDoor> doors;
  std::vector<BuildingWall> walls = {};
  double metres_per_unit = 1.0;  // of the drawing: a pixel of its picture
};

struct BuildingLift {
  struct Stop {
    std::size_t level = 0;  // index into Building::levels
    Pose2 T_level_cabin;
  };
  std::string name;
  std::vector<Stop> stops;
  double width = 0.0;  // m, of the cabin along its x
  double depth = 0.0;
  std::vector<BuildingDoor> doors = {};  // T_level_door: in the cabin's frame
};

struct BuildingRemark {
  std::string item;  // "levels L1", "lifts Lift1"
  bool refused = false;
  std::string why;
};

struct Building {
  std::string name;
  std::vector<BuildingLevel> levels;  // from the lowest
  std::vector<BuildingLift> lifts;
  std::vector<BuildingRemark> remarks;
};

// Lengths come from the measured lines of each level. A lift is placed on levels other than its own by the fiducials of
// the same names (the similarity that fits them best: Umeyama 1991). INVALID_ARGUMENT: it is not such a file. A part
// that cannot be read gives a remark and does not affect the others.
absl::StatusOr<Building> ParseBuilding(const std::string& yaml);

}  // namespace enfilade::prior
