// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/pose2.h"
#include "core/grid/occupancy_grid.h"
#include "core/rooms/room_options.h"

// Cuts an occupancy grid into its rooms (docs/rooms.md). Two rooms meet at doors: gaps in slender walls. Nothing is cut
// because it is narrow.
namespace enfilade::rooms {

// The ends of a door that a robot is known to have driven through, map frame, m. It may be half a metre wrong.
struct PassageHint {
  Eigen::Vector2d a = Eigen::Vector2d::Zero();
  Eigen::Vector2d b = Eigen::Vector2d::Zero();

  friend bool operator==(const PassageHint&, const PassageHint&) = default;
};

// Across a door whose pose faces through it; `width`: m, 0 if the robot did not measure it.
PassageHint PassageThrough(const Pose2& T_map_door, double width);

// What is known beside the grid; both may be empty.
struct RoomEvidence {
  std::span<const PassageHint> passages{};
  std::span<const Eigen::Vector2d> trajectory{};  // where robots have been, map frame, m: free ground
};

struct Room {
  int id = 0;                                        // its label: 1, 2, ...
  double area_m2 = 0.0;                              // of its free cells
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  // the point farthest from its walls and doors, map frame, m
  bool entered = false;                              // a point of the trajectory lies in it
};

struct Door {
  Eigen::Vector2d a = Eigen::Vector2d::Zero();  // its ends, map frame, m
  Eigen::Vector2d b = Eigen::Vector2d::Zero();
  std::array<int, 2> rooms{};  // the lower id first

  double width() const { return (b - a).norm(); }
};

struct RoomPartition {
  grid::GridGeometry geometry;
  std::vector<std::uint16_t> labels;  // one for each cell: its room's id, 0 = in no room
  std::vector<Room> rooms;            // room i has the id i + 1
  std::vector<Door> doors;

  // The room at a point in the map frame; 0: none, or outside of the grid.
  int RoomAt(const Eigen::Vector2d& p_map) const;
};

// Rooms are numbered by area, the largest first; at most 65,535 get a number. The same input gives the same result.
RoomPartition PartitionRooms(const grid::OccupancyGrid& grid, const RoomOptions& options = {},
                             const RoomEvidence& evidence = {});

}  // namespace enfilade::rooms
