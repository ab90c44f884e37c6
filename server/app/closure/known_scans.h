// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "core/closure/closure_options.h"
#include "core/closure/scan_location.h"
#include "core/graph/graph_snapshot.h"
#include "server/app/closure/closure_stores.h"
#include "server/app/closure/seen_grounds.h"

namespace enfilade::server {

// What robots have seen of a map from inside it.
struct KnownScans {
  std::shared_ptr<const closure::SeenGround> ground;  // null: nothing, or not read
  bool recording = false;                             // sessions in it are still recording
  bool mapping = false;                               // sessions in it are recorded, but not mapped yet
};

// Where known scans are read from. All must outlive it.
struct KnownScansScope {
  const DoorClosureStores& stores;
  const SiteId& site;
  const graph::GraphSnapshot& graph;
  const closure::DoorClosureOptions& options;
  SeenGrounds& grounds;  // kept from one verdict to the next
};

// The keyframes' scans within locate_reach of the predicted pose of the robot, locate_scans at most, evenly chosen: of
// the sessions in the map, and of those that entered it, from the door on. Hits that were seen through the map's doors
// are removed. While a door at the end of a session may still be unknown (the session is recording, or its passage is
// not judged), its last locate_tail is left out. No scans are read if the prediction is not sure enough to use them
// (closure::IsSureEnoughForScans): a graph that is not sure predicts the robot in dozens of maps. Errors are the
// stores'.
absl::StatusOr<KnownScans> ReadKnownScans(const KnownScansScope& scope, const MapId& map,
                                          const PoseWithCovariance& predicted);

// The scans themselves, of keyframes within `reach`, m, of T_map_place, with all hits. The other rules are the same.
struct ScansAround {
  std::vector<closure::PlacedScan> scans;
  bool recording = false;
  bool mapping = false;
};
absl::StatusOr<ScansAround> ReadScansAround(const KnownScansScope& scope, const MapId& map, const Pose2& T_map_place,
                                            double reach);

// T_map_door of the map's link points.
std::vector<Pose2> DoorsOf(const graph::GraphSnapshot& graph, const MapId& map);

}  // namespace enfilade::server
