// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "core/sensor/scan_pairing.h"
#include "core/slam/slam_options.h"
#include "core/slam/state/existing_map.h"
#include "storage/sessions/record_store.h"
#include "storage/sessions/session_store.h"

namespace enfilade::server {

// Where a session enters its map, with what its robot saw there: of the last scans of the session before, the one whose
// odometry is nearest to the entry's. Without it, the way to the session's first scan is odometry's alone. `session`
// must have an entry pose. Errors are the stores'.
absl::StatusOr<slam::ExistingMapEntry> ReadEntry(const storage::SessionStore& sessions,
                                                 const storage::RecordStore& records,
                                                 const sensor::ScanPairingOptions& pairing,
                                                 const slam::SlamOptions& slam, const storage::Session& session);

}  // namespace enfilade::server
