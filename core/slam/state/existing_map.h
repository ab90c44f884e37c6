// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "core/base/binary.h"
#include "core/geometry/pose2.h"
#include "core/grid/occupancy_grid.h"
#include "core/grid/scan_rays.h"
#include "core/slam/slam_options.h"
#include "core/slam/submaps/finished_submap.h"
#include "core/slam/submaps/submap.h"

namespace enfilade::slam {

// Where the robot enters an existing map.
struct ExistingMapEntry {
  PoseWithCovariance T_map_robot;     // m, rad
  std::optional<Pose2> T_odom_robot;  // odometry at that pose; unset: the pose is that of the first scan
  // What a scan at that pose and odometry saw, in the robot's frame. The first scan is matched to it.
  std::optional<grid::ScanRays> seen = {};
};

// A map that mapping continues, in its frame. Its grid becomes submap 0, which never moves.
struct ExistingMap {
  // Cells on the lattice of the options' resolution (ResampleToLattice in core/grid/overlay.h). Without cells the map
  // is only a frame.
  grid::OccupancyGrid grid;
  ExistingMapEntry entry;
};

// The content of submap 0: no keyframes; its frame is the map's.
SubmapContent ContentOf(const grid::OccupancyGrid& grid, const SlamOptions& options);

// The robot's pose at a scan with odometry `T_odom_now`: the entry's pose, moved by the odometry since. Its covariance
// is the sum of the entry's, the odometry's and that of matching a scan (graph.match_sigma_floor, match_yaw_floor).
PoseWithCovariance PoseAtScan(const ExistingMapEntry& entry, const std::optional<Pose2>& T_odom_now,
                              const SlamOptions& options);

// Submap 0 after the first own submap was begun at `T_map_first`, in the existing map's frame.
FinishedSubmap TiedToFirst(const FinishedSubmap& existing, const PoseWithCovariance& T_map_first,
                           const SlamOptions& options);

// Three standard deviations of the entry: of the translation in its least certain direction (m) and of the yaw (rad).
struct EntryReach {
  double translation = 0.0;
  double yaw = 0.0;
};
EntryReach ReachOf(const ExistingMapEntry& entry);

// For checkpoints: exact, without `seen`.
void PutEntry(BinaryWriter& writer, const std::optional<ExistingMapEntry>& entry);
std::optional<ExistingMapEntry> GetEntry(BinaryReader& reader);

}  // namespace enfilade::slam
