// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/geometry/pose2.h"

namespace enfilade::sources {

// What an Open-RMF traffic editor's building.yaml says of floors, doors and lifts. Each level has a frame of its own:
// metres, x to the right and y up of its drawing, from the drawing's upper left corner.

struct BuildingDoor {
  std::string name;
  Pose2 T_level_door;  // the middle of its opening, x through it
};

struct BuildingLevel {
  std::string name;
  int level = 0;                         // 0: the lowest that is not below the ground
  std::vector<Eigen::Vector2d> outline;  // m: the convex hull of its floors or, without, of its walls; may be empty
  std::vector<BuildingDoor> doors;
};

struct BuildingLift {
  struct Stop {
    std::size_t level = 0;  // index into Building::levels
    Pose2 T_level_cabin;
  };
  std::string name;
  std::vector<Stop> stops;
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

// Lengths come from the measured lines of each level; a lift's place on other levels than its own from the fiducials of
// the same names (the similarity that fits them best: Umeyama 1991). INVALID_ARGUMENT where it is no such file.
absl::StatusOr<Building> ParseBuilding(const std::string& yaml);

}  // namespace enfilade::sources
