// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "absl/status/statusor.h"
#include "core/geo/georeference.h"
#include "core/graph/global_pose.h"
#include "core/graph/graph_snapshot.h"
#include "storage/graph_store.h"

namespace enfilade::server {

// A site's graph at one version with what answers are made from. Immutable: shared by all who read it.
struct SiteGraph {
  explicit SiteGraph(graph::GraphSnapshot snapshot) : poses(std::move(snapshot)) {}

  const graph::GraphSnapshot& graph() const { return poses.graph(); }

  graph::WorldPoses poses;
  std::int64_t solution_version = 0;  // that the last optimisation made; 0: none, or none that holds for this root
  std::vector<storage::ControlPoint> control_points;
  std::optional<geo::GeoreferenceFit> georeference;  // unset: too few control points, or they do not fit the graph
};

// What the store tells of changes, for the snapshot.
graph::SnapshotChanges ToSnapshotChanges(const storage::GraphChanges& changes);

// The last optimisation at or before the present version, as the snapshot wants it; null where there is none, or none
// of the present root.
std::shared_ptr<const graph::SolvedGraph> ToSolvedGraph(const std::vector<storage::MapPose>& poses,
                                                        std::int64_t version, const MapId& root);

// The control points in the world frame, fitted. FAILED_PRECONDITION where a map is not joined to the root; else as
// FitGeoreference.
absl::StatusOr<geo::GeoreferenceFit> FitControlPoints(const graph::WorldPoses& poses,
                                                      const std::vector<storage::ControlPoint>& points);

// What the optimisation found, for the store.
storage::GraphSolution ToStored(const graph::WorldPoses& solved, const graph::SolvedGraph& solution);

}  // namespace enfilade::server
