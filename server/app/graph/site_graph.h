// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "core/geo/georeference.h"
#include "core/graph/global_pose.h"
#include "core/graph/graph_snapshot.h"
#include "server/app/graph/placed_link_points.h"
#include "storage/graph/graph_store.h"

namespace enfilade::server {

// A site's graph at one version, with the values derived from it. Immutable and shared.
struct SiteGraph {
  // All maps and link points, each by id.
  struct Lists {
    std::vector<const graph::MapInGraph*> maps;
    std::vector<const graph::LinkPoint*> link_points;
  };

  explicit SiteGraph(graph::GraphSnapshot snapshot, PlacedLinkPoints link_points = {});
  SiteGraph(SiteGraph&&) noexcept;
  ~SiteGraph();

  const graph::GraphSnapshot& graph() const { return poses.graph(); }
  // Sorted at the first call. Thread-safe.
  const Lists& lists() const;

  graph::WorldPoses poses;
  PlacedLinkPoints placed;
  std::int64_t solution_version = 0;  // made by the last optimisation; 0: none, or none for this root
  std::vector<storage::ControlPoint> control_points;
  std::optional<geo::GeoreferenceFit> georeference;  // unset: too few control points, or they do not fit

 private:
  struct SortedOnce;
  std::unique_ptr<SortedOnce> lists_;
};

// Converts changes from the store for graph::Apply.
graph::SnapshotChanges ToSnapshotChanges(const storage::GraphChanges& changes);

// Converts the map poses of optimisation `version` for graph::Apply: `old` with the changes since then, or, if null,
// all poses. Null if they are for another root than `root`.
std::shared_ptr<const graph::SolvedGraph> ToSolvedGraph(const graph::SolvedGraph* old,
                                                        const storage::MapPoseChanges& changes, std::int64_t version,
                                                        const MapId& root);

// Fits a georeference to the control points. FAILED_PRECONDITION if a map is not joined to the root; otherwise as
// geo::FitGeoreference.
absl::StatusOr<geo::GeoreferenceFit> FitControlPoints(const graph::WorldPoses& poses,
                                                      const std::vector<storage::ControlPoint>& points);

// Converts the result of an optimisation of `before` for the store: the poses and places that it changes by more than
// rounding. `solved` is before's graph with the solution.
storage::GraphSolution ToStored(const SiteGraph& before, const graph::WorldPoses& solved,
                                const graph::SolvedGraph& solution);

}  // namespace enfilade::server
