// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "core/grid/occupancy_grid.h"
#include "core/sensor/scan_pairing.h"
#include "core/slam/mapper/back_end.h"
#include "core/slam/mapper/map_renderer.h"
#include "core/slam/slam_map.h"
#include "core/slam/slam_options.h"
#include "core/slam/state/existing_map.h"
#include "core/slam/state/mapper_state.h"

namespace enfilade::slam {

// A mapped session.
struct ChainedSession {
  SlamMap map;             // with its submaps' contents; without the existing map that it continued
  ErrorStatistics errors;  // of its matches
  // Those of its keyframes and, last, of the trajectory's last point, in the order of the log.
  std::vector<sensor::PairedScan> scans;
};

// What a chain has become.
struct ChainedMap {
  grid::OccupancyGrid grid;             // what the scans have shown, without an existing map; without cells: nothing
  std::vector<StampedPose> trajectory;  // of all used scans, by time
  double variance_factor = 1.0;         // state/variance_factor.h
};

// Makes one map of sessions that follow each other, of the submaps that were made of each: scans are neither matched
// nor inserted again. A session is tied to the one before by odometry and by matching its first scan to the last
// submap. Its loop closures are kept, and its keyframes are looked for in the sessions before as Mapper does it. The
// same sessions in the same order give the same map, bit for bit, also if the map was asked for in between.
//
// Not thread-safe.
class SessionChain {
 public:
  // Without an existing map, the frame is the robot's at the first keyframe.
  SessionChain(const SlamOptions& options, const std::optional<ExistingMap>& existing);

  // A session without keyframes changes nothing. FAILED_PRECONDITION: its submaps have another resolution than the
  // options, are not finished or not all there. DATA_LOSS: they are damaged. The chain is then as before.
  absl::Status Append(const ChainedSession& session);

  // The map as if no session followed.
  ChainedMap Finish();

  // Bytes of memory held.
  std::size_t bytes() const;

 private:
  grid::ScanRays RaysOf(const sensor::PairedScan& scan) const;
  grid::ScanRays SeenFirst(const std::map<std::int64_t, SlamNode>& nodes,
                           const std::vector<sensor::PairedScan>& scans) const;
  Pose2 Tie(const sensor::PairedScan& scan, const grid::ScanRays& seen, const Pose2& T_robot_submap,
            FinishedSubmap& submap);

  SlamOptions options_;
  MapperState state_;  // no submap is active; `track` is where the last session ended, in its last submap
  std::vector<TrajectoryPoint> trajectory_;
  BackEnd back_end_;
  std::optional<MapRenderer> renderer_;  // that has drawn the map before
};

}  // namespace enfilade::slam
