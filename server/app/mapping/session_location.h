// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/grid/occupancy_grid.h"
#include "core/localization/recent_scans.h"
#include "core/localization/searchable_map.h"
#include "core/sensor/record.h"
#include "core/sensor/scan_pairing.h"
#include "core/slam/state/existing_map.h"

namespace enfilade::server {

// Finds the robot of a session in the existing map that the session is to continue, by the session's first scans, if
// nobody has said where the robot entered it. Not thread-safe. Deterministic: the same records give the same entry,
// however they are divided.
class SessionLocation {
 public:
  // How far the robot may drive, or how long a robot without odometry may look around, before it must be located.
  static constexpr double kMaxTravelled = 20.0;  // m
  static constexpr double kMaxSeconds = 60.0;    // s

  SessionLocation(const sensor::ScanPairingOptions& pairing, grid::OccupancyGrid map);

  // In the order of the log; not after the robot is located. FAILED_PRECONDITION: no pose was certain on the way that
  // the robot may drive; it says why.
  absl::Status Add(sensor::Record record);
  // The log has ended. FAILED_PRECONDITION: there are scans, and no pose was certain.
  absl::Status Finish();

  // The existing map with the robot's entry, once that is certain.
  std::optional<slam::ExistingMap> TakeLocated();
  // So far, there is nothing that could lie in the wrong place.
  bool has_no_scans() const { return recent_.scans().empty(); }
  // Memory held, about.
  std::size_t bytes() const;

 private:
  absl::Status LookAround();
  absl::Status Locate();
  absl::Status NotFoundIn() const;

  sensor::ScanPairing pairing_;
  grid::OccupancyGrid map_;
  std::shared_ptr<const localization::SearchableMap> searchable_;
  localization::RecentScans recent_;
  std::vector<sensor::PairedScan> settled_;  // empty between calls
  std::optional<slam::ExistingMapEntry> entry_;
  std::string reason_;  // for people
};

}  // namespace enfilade::server
