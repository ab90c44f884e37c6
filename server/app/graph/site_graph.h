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
  explicit SiteGraph(GraphSnapshot snapshot) : poses(std::move(snapshot)) {}

  const GraphSnapshot& graph() const { return poses.graph(); }

  WorldPoses poses;
  std::int64_t solution_version = 0;  // that the last optimisation made; 0: none, or none that holds for this root
  std::vector<ControlPoint> control_points;
  std::optional<GeoreferenceFit> georeference;  // unset: too few control points, or they do not fit the graph
};

// What the store tells of changes, for the snapshot.
SnapshotChanges ToSnapshotChanges(const GraphChanges& changes);

// The last optimisation at or before the present version, as the snapshot wants it; null where there is none, or none
// of the present root.
std::shared_ptr<const SolvedGraph> ToSolvedGraph(const std::vector<MapPose>& poses, std::int64_t version,
                                                 const MapId& root);

// The control points in the world frame, fitted. FAILED_PRECONDITION where a map is not joined to the root; else as
// FitGeoreference.
absl::StatusOr<GeoreferenceFit> FitControlPoints(const WorldPoses& poses, const std::vector<ControlPoint>& points);

// What the optimisation found, for the store.
GraphSolution ToStored(const WorldPoses& solved, const SolvedGraph& solution);

}  // namespace enfilade::server
