// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/grid/occupancy_grid.h"
#include "core/rooms/room_partition.h"

// How well a partition into rooms agrees with the truth.
namespace enfilade::testing {

struct PlanScore {
  int rooms = 0;     // true ones of more than 2 m^2
  int found = 0;     // by one segment, used once, with an intersection over union of at least 0.7
  int segments = 0;  // of the partition
  int extra() const { return segments - found; }
};

// The true room of each cell, from 1, by a plan with each door closed by a line, so that a room is a connected piece of
// free cells; 0: none.
std::vector<int> RoomsOfTruth(const grid::OccupancyGrid& truth);

// `truth`: the true room of each of the partition's cells, from 1; 0: none.
PlanScore ScorePlan(const rooms::RoomPartition& partition, std::span<const int> truth);

// Where a robot was by its map, and by the truth.
struct DrivePoint {
  Eigen::Vector2d p_map;
  std::string area;
};

// A robot's centre crossed a door's line.
struct DrivePassage {
  Eigen::Vector2d p_map;
  std::string door;
};

struct DriveScore {
  int areas = 0;          // that the robot entered
  int rooms = 0;          // that it was in by the partition
  int doubled = 0;        // areas with more than one room
  int merged = 0;         // areas that share a room with another
  int doors = 0;          // that the robot passed
  int missed = 0;         // passages at which the room did not change, or not once
  int false_changes = 0;  // of the room, at no passage
  bool exact() const { return doubled == 0 && merged == 0 && missed == 0 && false_changes == 0; }
  std::vector<std::string> faults;  // for people
};

// One room for each area entered, and one change of the room at each door passed. A change counts for a passage up to
// 1 m away. Areas that the robot was in for less than 0.5 m are not counted.
DriveScore ScoreDrive(const rooms::RoomPartition& partition, std::span<const DrivePoint> drive,
                      std::span<const DrivePassage> passages);

}  // namespace enfilade::testing
