// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/edge_shares.h"

#include <algorithm>
#include <unordered_map>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/optimize/edge_error.h"
#include "core/optimize/graph_layout.h"
#include "core/optimize/indexed_graph.h"
#include "core/optimize/linear/block_cholesky.h"
#include "core/optimize/linear/normal_equations.h"

namespace enfilade::optimize {
namespace {

// The columns of H^-1 that belong to the variable at `position`, in elimination order.
absl::StatusOr<Eigen::Matrix<double, Eigen::Dynamic, 3>> InverseColumns(const IndexedGraph& graph,
                                                                        const GraphLayout& layout, int position) {
  NormalEquations equations;
  Linearize(graph, layout, {}, equations);
  if (!Factorize(layout.structure, equations.H)) {
    return FailedPrecondition("pose graph: there are no covariances: the normal equations are singular");
  }
  Eigen::Matrix<double, Eigen::Dynamic, 3> columns(3 * layout.structure.size, 3);
  for (int k = 0; k < 3; ++k) {
    Eigen::VectorXd column = Eigen::VectorXd::Unit(columns.rows(), 3 * position + k);
    SolveFactorized(layout.structure, equations.H, column);
    columns.col(k) = column;
  }
  return columns;
}

}  // namespace

absl::StatusOr<std::vector<Eigen::Matrix3d>> EdgeShares(const PoseGraph& graph, const std::vector<std::int64_t>& fixed,
                                                        std::int64_t node) {
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<IndexedGraph> components, IndexComponents(graph, fixed));
  std::vector<Eigen::Matrix3d> shares(graph.edges.size(), Eigen::Matrix3d::Zero());
  for (const IndexedGraph& component : components) {
    const auto found = std::find_if(component.sources.begin(), component.sources.end(), [&](int source) {
      return graph.nodes[static_cast<std::size_t>(source)].id == node;
    });
    if (found == component.sources.end()) continue;
    const GraphLayout layout = LayOut(component);
    const int position = layout.position[static_cast<std::size_t>(found - component.sources.begin())];
    if (position < 0) return shares;
    ENFILADE_ASSIGN_OR_RETURN(const auto columns, InverseColumns(component, layout, position));
    std::unordered_map<std::int64_t, std::size_t> index;  // in the component
    for (std::size_t i = 0; i < component.sources.size(); ++i) {
      index.emplace(graph.nodes[static_cast<std::size_t>(component.sources[i])].id, i);
    }
    const auto with_node = [&](std::size_t i) -> Eigen::Matrix3d {
      const int at = layout.position[i];
      return at < 0 ? Eigen::Matrix3d(Eigen::Matrix3d::Zero()) : Eigen::Matrix3d(columns.middleRows<3>(3 * at));
    };
    for (std::size_t k = 0; k < graph.edges.size(); ++k) {
      const PoseGraphEdge& edge = graph.edges[k];
      const auto from = index.find(edge.from);
      if (!edge.enabled || from == index.end()) continue;
      const std::size_t to = index.at(edge.to);
      const LinearizedEdge line =
          LinearizeEdge(component.poses[from->second], component.poses[to], EdgeMeasurement(edge.T_from_to));
      const Eigen::Matrix3d error = line.J_from() * with_node(from->second) + line.J_to * with_node(to);
      shares[k] = error.transpose() * edge.information * error;
    }
    return shares;
  }
  return InvalidArgument("pose graph: there is no node {}", node);
}

}  // namespace enfilade::optimize
