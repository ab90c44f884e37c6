// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/geometry/pose2.h"
#include "tests/e2e/campus/drive_truth.h"
#include "tests/e2e/campus/trajectory_error.h"

namespace enfilade::testing {

// A picture of a building's rooms (ColouredRooms), and where it lies.
struct PicturedRooms {
  std::filesystem::path picture;
  Pose2 T_map_picture;      // of its lower left corner, in the one map that `enfilade slam` makes of the log
  double resolution = 0.0;  // m of a pixel
};

// Which rooms a robot was in by the picture, each named by its colour, as #rrggbb. Where it really was is not known:
// `trajectory`, in that one map, stands for it. A room through which it drove for less than 0.5 m counts as the room
// before, and so does a room of less than 2 m^2. Throws if the picture cannot be read.
DriveTruth RoomsEntered(const std::string& robot, const std::vector<TimedPose>& trajectory, const PicturedRooms& rooms);

}  // namespace enfilade::testing
