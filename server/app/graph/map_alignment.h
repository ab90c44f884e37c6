// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/geometry/pose2.h"
#include "core/localization/alignment/align_maps.h"
#include "server/app/graph/site_graphs.h"
#include "storage/call_context.h"
#include "storage/maps/map_store.h"
#include "storage/maps/revision_store.h"

namespace enfilade::server {

struct MapAlignmentRequest {
  SiteId site;
  MapId map_a;
  MapId map_b;
  std::optional<Pose2> T_a_b;  // a guess; unset: by the graph
  double radius = 5.0;         // m, how far off the guess may be
  double yaw_range = 0.5;      // rad
};

struct MapAlignmentStores {
  const storage::MapReader& maps;
  const storage::RevisionStore& revisions;
};

// Fits one map to another by their newest revisions (localization::AlignMaps). Stores nothing; computes for up to
// seconds. INVALID_ARGUMENT: one map twice, maps of two levels, a guess that is out of range; NOT_FOUND;
// FAILED_PRECONDITION: a map without a revision, or without a guess no link points join the maps. CANCELLED and
// DEADLINE_EXCEEDED soon after the call is.
absl::StatusOr<localization::MapAlignment> AlignStoredMaps(const storage::CallContext& context,
                                                           const MapAlignmentStores& stores, SiteGraphs& graphs,
                                                           const MapAlignmentRequest& request);

}  // namespace enfilade::server
