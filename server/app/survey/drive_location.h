// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "core/grid/occupancy_grid.h"
#include "core/localization/located_drive.h"
#include "core/localization/recent_scans.h"
#include "core/localization/searchable_map.h"
#include "core/sensor/record.h"
#include "core/sensor/scan_pairing.h"
#include "core/slam/state/existing_map.h"

namespace enfilade::server {

// Finds a whole drive in what was mapped before it, by its scans: every few metres the robot is located by those of the
// last metres, until several of these poses agree with each other by odometry. Not thread-safe.
class DriveLocation {
 public:
  DriveLocation(const sensor::ScanPairingOptions& pairing, const grid::OccupancyGrid& level);

  // In the order of the drive's logs.
  absl::Status Add(sensor::Record record);
  // Nothing that comes later can change the result.
  bool complete() const;
  // The robot on the level at one moment of the drive. Unset: nowhere known, not certain, or contradictory.
  std::optional<slam::ExistingMapEntry> Finish();

 private:
  absl::Status Locate();

  sensor::ScanPairing pairing_;
  std::shared_ptr<const localization::SearchableMap> level_;
  localization::RecentScans recent_;
  std::vector<sensor::PairedScan> settled_;  // empty between calls
  std::vector<localization::LocatedMoment> moments_;
  int attempts_ = 0;
};

}  // namespace enfilade::server
