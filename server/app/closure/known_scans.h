// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "core/closure/scan_location.h"
#include "server/app/closure/passage_scene.h"

namespace enfilade::server {

// What robots have seen of a map from inside it.
struct KnownScans {
  std::vector<closure::PlacedScan> scans;
  // Sessions that go on recording in it, and those that are recorded and not mapped yet.
  bool recording = false;
  bool mapping = false;
};

// The keyframes' scans within locate_reach of `around`, locate_scans at most, evenly chosen: of the sessions in the
// map, and of those that entered it, from the door on. Without what they saw through the map's doors; where a door may
// not be known yet (a session goes on recording, or its passage is not judged), without its last locate_tail before it.
// Errors are the stores'.
absl::StatusOr<KnownScans> ReadKnownScans(const storage::CallContext& context, const PassageScene& passage,
                                          const MapId& map, const Pose2& around);

}  // namespace enfilade::server
