// SPDX-License-Identifier: Apache-2.0
#include "server/app/survey/drive_location.h"

#include <utility>

#include "core/base/status_macros.h"
#include "core/localization/localize.h"

namespace enfilade::server {
namespace {

// Poses that must agree with each other; fewer do at the end of a short drive.
constexpr std::size_t kEnough = 3;
// Bounds the time that a drive through unknown ground takes.
constexpr int kMaxAttempts = 40;

// Attempts have no scans in common, so that their errors do not either.
localization::RecentScansOptions Apart() {
  localization::RecentScansOptions options;
  options.spacing = options.window;
  return options;
}

}  // namespace

DriveLocation::DriveLocation(const sensor::ScanPairingOptions& pairing, const grid::OccupancyGrid& level)
    : pairing_(pairing),
      level_(std::make_shared<const localization::SearchableMap>(level, localization::LocalizationOptions())),
      recent_(Apart()) {}

bool DriveLocation::complete() const { return moments_.size() >= kEnough || attempts_ >= kMaxAttempts; }

absl::Status DriveLocation::Add(sensor::Record record) {
  pairing_.Add(record.sequence, std::move(record.payload), settled_);
  for (const sensor::PairedScan& scan : std::exchange(settled_, {})) {
    if (complete() || !scan.T_odom_robot) continue;
    if (recent_.Add(scan)) ENFILADE_RETURN_IF_ERROR(Locate());
  }
  return absl::OkStatus();
}

std::optional<slam::ExistingMapEntry> DriveLocation::Finish() {
  const auto start = localization::FindStart(moments_, recent_.travelled());
  if (!start) return std::nullopt;
  return slam::ExistingMapEntry{start->T_map_robot, start->T_odom_robot};
}

absl::Status DriveLocation::Locate() {
  ++attempts_;
  ENFILADE_ASSIGN_OR_RETURN(const localization::Localization found, localization::LocalizeIn(level_, recent_.scans()));
  if (found.poses.empty() || !found.poses.front().confident) return absl::OkStatus();
  moments_.push_back({found.poses.front().T_map_robot, *recent_.T_odom_robot(), recent_.travelled()});
  return absl::OkStatus();
}

}  // namespace enfilade::server
