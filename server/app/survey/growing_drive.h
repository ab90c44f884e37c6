// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/grid/occupancy_grid.h"
#include "core/sensor/record.h"
#include "core/sensor/scan_pairing.h"
#include "core/slam/mapper/map_renderer.h"
#include "core/slam/slam_map.h"
#include "core/slam/slam_options.h"
#include "core/slam/state/existing_map.h"

namespace enfilade::server {

// A drive from end to end, in its level's frame.
struct MappedDrive {
  grid::OccupancyGrid grid;                   // of this drive alone; no cells: nothing could be mapped
  std::vector<slam::StampedPose> trajectory;  // by time
  double variance_factor = 1.0;               // of its SLAM
};

// Maps a drive that may go on: what is added later costs hardly more than if it had been there at once, and the map is
// the same, bit for bit. Between calls of Extend it holds what a server stores of a session, and its picture in
// tiles unless they are large. Not thread-safe.
class GrowingDrive {
 public:
  // Of scans, only keyframes are mapped: those that a session's own mapping has chosen. Of the others the last one
  // alone is used, to tell where the drive ends. `is_keyframe` says nothing about other records.
  using Add = std::function<void(sensor::Record record, bool is_keyframe)>;
  using Feed = std::function<absl::Status(const Add& add)>;

  // Without `existing` the drive begins at its frame's origin.
  GrowingDrive(const sensor::ScanPairingOptions& pairing, const slam::SlamOptions& slam,
               const std::optional<slam::ExistingMap>& existing);

  // `feed` adds the records that are new, in the order of the drive's logs. Returns the map as if the drive ended here.
  // After an error, which may be that of `feed`, the drive is as it was before.
  absl::StatusOr<MappedDrive> Extend(const Feed& feed);

  // Memory held, about.
  std::size_t bytes() const;

 private:
  sensor::ScanPairingOptions pairing_;
  slam::SlamOptions slam_;
  // A mapper that is not finished.
  std::string checkpoint_;
  slam::SlamMap stored_;
  // The last scan, if it is no keyframe, and the odometry since: not in the mapper yet.
  std::vector<sensor::Record> tail_;
  std::optional<slam::MapRenderer> renderer_;  // that has drawn the map before
};

}  // namespace enfilade::server
