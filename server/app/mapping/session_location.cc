// SPDX-License-Identifier: Apache-2.0
#include "server/app/mapping/session_location.h"

#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/localization/localize.h"

namespace enfilade::server {

SessionLocation::SessionLocation(const sensor::ScanPairingOptions& pairing, grid::OccupancyGrid map)
    : pairing_(pairing),
      map_(std::move(map)),
      searchable_(std::make_shared<const localization::SearchableMap>(map_, localization::LocalizationOptions())) {}

absl::Status SessionLocation::Add(sensor::Record record) {
  pairing_.Add(record.sequence, std::move(record.payload), settled_);
  return LookAround();
}

absl::Status SessionLocation::Finish() {
  pairing_.Flush(settled_);
  ENFILADE_RETURN_IF_ERROR(LookAround());
  if (!entry_ && recent_.T_odom_robot()) ENFILADE_RETURN_IF_ERROR(Locate());
  return entry_ || has_no_scans() ? absl::OkStatus() : NotFoundIn();
}

std::optional<slam::ExistingMap> SessionLocation::TakeLocated() {
  if (!entry_) return std::nullopt;
  return slam::ExistingMap{std::move(map_), *entry_};
}

absl::Status SessionLocation::LookAround() {
  for (const sensor::PairedScan& scan : std::exchange(settled_, {})) {
    if (entry_) break;
    if (recent_.Add(scan)) ENFILADE_RETURN_IF_ERROR(Locate());
    const bool far = recent_.T_odom_robot() ? recent_.travelled() > kMaxTravelled : recent_.seconds() > kMaxSeconds;
    if (!entry_ && far) return NotFoundIn();
  }
  return absl::OkStatus();
}

absl::Status SessionLocation::Locate() {
  ENFILADE_ASSIGN_OR_RETURN(const localization::Localization found,
                            localization::LocalizeIn(searchable_, recent_.scans()));
  reason_ = found.reason;
  if (found.poses.empty() || !found.poses.front().confident) return absl::OkStatus();
  entry_ = slam::ExistingMapEntry{found.poses.front().T_map_robot, recent_.T_odom_robot()};
  return absl::OkStatus();
}

std::size_t SessionLocation::bytes() const { return map_.cells.capacity() + (searchable_ ? searchable_->bytes() : 0); }

absl::Status SessionLocation::NotFoundIn() const {
  return FailedPrecondition(
      "the robot was not located in the map, which has content already ({}): give its pose in the map when the session "
      "begins (entry.pose_map_robot), or record a new map",
      reason_);
}

}  // namespace enfilade::server
