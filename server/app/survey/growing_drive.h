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
// the same, bit for bit. Between calls of Extend it holds no more than what a server stores of a session. Not
// thread-safe.
class GrowingDrive {
 public:
  using Feed = std::function<absl::Status(const std::function<void(sensor::Record)>& add)>;

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
};

}  // namespace enfilade::server
