// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "core/base/binary.h"
#include "core/geometry/pose2.h"
#include "core/grid/occupancy_grid.h"
#include "core/slam/slam_options.h"
#include "core/slam/submaps/submap.h"

namespace enfilade::slam {

// Where the robot is in a map that is there already.
struct ExistingMapEntry {
  PoseWithCovariance T_map_robot;     // m, rad
  std::optional<Pose2> T_odom_robot;  // what odometry says there; unset: the pose is that of the first scan
};

// A map that is there already, in whose frame mapping goes on: what it knows becomes submap 0, which never moves.
struct ExistingMap {
  // Its cells on the lattice of the options' resolution (ResampleToLattice in core/grid/overlay.h); may have none: then
  // the map is but a frame.
  grid::OccupancyGrid grid;
  ExistingMapEntry entry;
};

// Submap 0's content: no keyframes, the map's frame for its own.
SubmapContent ContentOf(const grid::OccupancyGrid& grid, const SlamOptions& options);

// The robot's pose at a scan at which odometry says `T_odom_now`: the entry's, moved on by odometry, whose uncertainty
// adds to the entry's; and no surer than matching a scan is.
PoseWithCovariance PoseAtScan(const ExistingMapEntry& entry, const std::optional<Pose2>& T_odom_now,
                              const SlamOptions& options);

// Three standard deviations of the entry, in the direction that it leaves the most open: m and rad.
struct EntryReach {
  double translation = 0.0;
  double yaw = 0.0;
};
EntryReach ReachOf(const ExistingMapEntry& entry);

// For checkpoints: exact.
void PutEntry(BinaryWriter& writer, const std::optional<ExistingMapEntry>& entry);
std::optional<ExistingMapEntry> GetEntry(BinaryReader& reader);

}  // namespace enfilade::slam
