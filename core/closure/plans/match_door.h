// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/closure/closure_options.h"
#include "core/closure/scan_location.h"
#include "core/geometry/pose2.h"
#include "core/graph/graph_snapshot.h"

namespace enfilade::closure {

// Two maps before and behind a door that no robot has driven through: does what was seen through it from the one lie on
// the walls of the other?

// T_there_here of two maps by everything that the graph knows, its plans included, with the covariance of one relative
// to the other: that of an optimisation that holds `there`. Unset: nothing joins them. Errors of graph::OptimizeGraph.
absl::StatusOr<std::optional<PoseWithCovariance>> PredictBetween(const graph::GraphSnapshot& graph, const MapId& there,
                                                                 const MapId& here);

// The hits that scans of a map saw through a door of it, in the door's frame, m: the beam crosses the door's opening
// and ends beyond its wall and frame, which are of both sides. x of T_map_door points out of the map.
std::vector<Eigen::Vector2d> PointsThroughDoor(const std::vector<PlacedScan>& scans, const Pose2& T_map_door,
                                               double width);

// A door as two maps have it.
struct DoorInMaps {
  Pose2 T_here_door = {};
  Pose2 T_there_door = {};
};

struct DoorMatch {
  bool contradicted = false;                            // the scans have the maps elsewhere
  std::optional<PoseWithCovariance> T_there_door = {};  // of `here`'s door; unset: neither direction tells
  std::string reason = {};
};

// `forth`: what was seen from `here`, in the frame of its door, located in `there`. `back`: the other way round. One
// that is accepted suffices, if the other one is accepted nowhere else; if both are accepted, their poses must pass the
// gate against each other, and the surer one counts.
DoorMatch JudgeDoorScans(const ScanLocation& forth, const ScanLocation& back, const DoorInMaps& door,
                         const DoorClosureOptions& options);

}  // namespace enfilade::closure
