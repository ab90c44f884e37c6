// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/rooms/room_partition.h"
#include "core/survey/level_survey.h"
#include "core/survey/survey_options.h"

namespace enfilade::survey {

// A stretch of one session's drive that lies in one room.
struct Stretch {
  std::size_t drive = 0;
  std::size_t session = 0;  // of the drive
  std::size_t first = 0;    // visit
  std::size_t last = 0;     // visit, inclusive
  int room = 0;             // its label, > 0
  double length = 0.0;      // m
};

// A robot's way out of one room into another.
struct Crossing {
  int from = 0;  // rooms
  int to = 0;
  Pose2 T_level_before = {};  // the robot's poses on both sides
  Pose2 T_level_behind = {};
};

// Where all drives of a level were.
struct RoomsOfDrives {
  std::vector<Stretch> stretches = {};  // by drive, in order of time
  std::vector<Crossing> crossings = {};
};

// Labels the drives with rooms. A room that the robot has only looked into (`reach`) counts as the one before.
RoomsOfDrives FindRooms(const LevelSurvey& survey, const rooms::RoomPartition& partition, const SurveyOptions& options);

}  // namespace enfilade::survey
