// SPDX-License-Identifier: Apache-2.0
#include "core/prior/slam/piece_graph.h"

#include <Eigen/Cholesky>
#include <memory>
#include <utility>

#include "core/base/status_macros.h"
#include "core/graph/graph_optimization.h"
#include "core/graph/graph_snapshot.h"
#include "fmt/format.h"

namespace enfilade::prior {

absl::StatusOr<SolvedPieces> SolvePieces(const CutMap& cut, const graph::PlanTies& ties) {
  graph::SnapshotChanges changes{.version = 1, .root = cut.pieces.front().id};
  for (const MapPiece& piece : cut.pieces) changes.maps.push_back({.id = piece.id});
  for (std::size_t i = 0; i < cut.links.size(); ++i) {
    const PieceLink& link = cut.links[i];
    graph::LinkPoint point{.id = LinkPointId(fmt::format("link-{}", i))};
    point.anchors = {{cut.pieces[link.from].id, link.T_from_to, link.covariance}, {cut.pieces[link.to].id, {}, {}}};
    point.anchors.back().covariance.setZero();
    changes.link_points.push_back(std::move(point));
  }
  changes.plans = {{PriorMapId("plan"), "", std::make_shared<const graph::PlanTies>(ties)}};
  ENFILADE_ASSIGN_OR_RETURN(const graph::GraphSnapshot snapshot, graph::Apply({}, changes));
  ENFILADE_ASSIGN_OR_RETURN(const graph::SolvedGraph solution, graph::OptimizeGraph(snapshot));
  SolvedPieces solved;
  for (const MapPiece& piece : cut.pieces) {
    const auto found = solution.map_poses.find(piece.id);
    solved.T_map_piece.push_back(
        found == solution.map_poses.end() ? piece.T_map_piece : cut.pieces.front().T_map_piece * found->second.pose);
  }
  if (!solution.plans.empty()) solved.use = solution.plans.front();
  return solved;
}

double Chi2Of(const PieceLink& link, const std::vector<Pose2>& T_map_pieces) {
  const Pose2 T_from_to = Between(T_map_pieces[link.from], T_map_pieces[link.to]);
  const Eigen::Vector3d error(T_from_to.x - link.T_from_to.x, T_from_to.y - link.T_from_to.y,
                              WrapAngle(T_from_to.yaw - link.T_from_to.yaw));
  return error.dot(link.covariance.ldlt().solve(error));
}

}  // namespace enfilade::prior
