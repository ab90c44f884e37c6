// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "core/grid/occupancy_grid.h"
#include "core/sensor/record.h"
#include "core/sensor/scan_pairing.h"
#include "core/slam/mapper/log_mapper.h"
#include "core/slam/slam_map.h"
#include "core/slam/slam_options.h"
#include "core/slam/state/existing_map.h"

namespace enfilade::server {

// A drive from end to end, in its level's frame.
struct MappedDrive {
  grid::OccupancyGrid grid;                   // of this drive alone; no cells: nothing could be mapped
  std::vector<slam::StampedPose> trajectory;  // by time
  double variance_factor = 1.0;               // of its SLAM

  std::size_t bytes() const;
};

// Maps a drive that may go on: what is added later costs no more than if it had been there at once, and the map is the
// same, bit for bit. Not thread-safe.
class GrowingDrive {
 public:
  // Without `existing` the drive begins at its frame's origin.
  GrowingDrive(const sensor::ScanPairingOptions& pairing, const slam::SlamOptions& slam,
               std::optional<slam::ExistingMap> existing);

  // In the order of the drive's logs.
  void Add(sensor::Record record) { mapper_.Add(std::move(record)); }
  // The map if the drive ends here. More may be added afterwards.
  absl::StatusOr<MappedDrive> Map();

  // Memory held, about.
  std::size_t bytes() const;

 private:
  sensor::ScanPairingOptions pairing_;
  slam::SlamOptions slam_;
  slam::LogMapper mapper_;  // never finished
  slam::SlamMap stored_;    // what mapper_ has mapped up to the last call of Map
};

}  // namespace enfilade::server
