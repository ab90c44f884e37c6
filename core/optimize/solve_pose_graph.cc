// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/solve_pose_graph.h"

#include <algorithm>
#include <unordered_map>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/optimize/graph_layout.h"
#include "core/optimize/indexed_graph.h"
#include "core/optimize/initialization/chordal.h"
#include "core/optimize/initialization/starts.h"
#include "core/optimize/linear/marginals.h"
#include "core/optimize/linear/normal_equations.h"
#include "core/optimize/minimize.h"

namespace enfilade::optimize {
namespace {

absl::Status Check(const SolveOptions& options) {
  if (!(options.kernel.width > 0.0))
    return InvalidArgument("the kernel's width is {}, not positive", options.kernel.width);
  if (options.max_iterations < 0) return InvalidArgument("max_iterations is negative");
  if (!(options.relative_tolerance >= 0.0 && options.step_tolerance >= 0.0)) {
    return InvalidArgument("a tolerance is negative");
  }
  return absl::OkStatus();
}

Minimum SolveComponent(const SolveOptions& options, const GraphLayout& layout, IndexedGraph& graph) {
  const MinimizeOptions minimize{options.kernel, options.max_iterations, options.relative_tolerance,
                                 options.step_tolerance};
  switch (options.initialisation) {
    case Initialisation::kAuto:
      return MinimizeFromSeveralStarts(options.minimizer, minimize, layout, graph);
    case Initialisation::kChordal:
      if (std::optional<std::vector<Pose2>> poses = ChordalPoses(graph, layout)) graph.poses = *std::move(poses);
      break;
    case Initialisation::kNone:
      break;
  }
  return options.minimizer(minimize, layout, graph);
}

// For each node whose covariance is wanted, by its position in the graph: its positions in
// SolveOptions::covariance_of.
absl::StatusOr<std::unordered_map<int, std::vector<int>>> WantedCovariances(const SolveOptions& options,
                                                                            const PoseGraph& graph) {
  std::unordered_map<int, std::vector<int>> wanted;
  if (options.covariance_of.empty()) return wanted;
  std::unordered_map<std::int64_t, int> index;
  for (std::size_t i = 0; i < graph.nodes.size(); ++i) index.emplace(graph.nodes[i].id, static_cast<int>(i));
  for (std::size_t k = 0; k < options.covariance_of.size(); ++k) {
    const auto found = index.find(options.covariance_of[k]);
    if (found == index.end()) {
      return InvalidArgument("pose graph: there is no node {} to compute the covariance of", options.covariance_of[k]);
    }
    wanted[found->second].push_back(static_cast<int>(k));
  }
  return wanted;
}

absl::Status AddCovariances(const SolveOptions& options, const std::unordered_map<int, std::vector<int>>& wanted,
                            const GraphLayout& layout, const IndexedGraph& graph, SolveReport& report) {
  std::vector<int> columns;
  std::vector<const std::vector<int>*> targets;
  for (std::size_t i = 0; i < graph.poses.size(); ++i) {
    const auto found = wanted.find(graph.sources[i]);
    if (found == wanted.end() || layout.position[i] < 0) continue;
    columns.push_back(layout.position[i]);
    targets.push_back(&found->second);
  }
  if (columns.empty()) return absl::OkStatus();
  NormalEquations equations;
  Linearize(graph, layout, options.kernel, equations);
  if (!Factorize(layout.structure, equations.H)) {
    return FailedPrecondition(
        "pose graph: there are no covariances: the normal equations at the solution are singular");
  }
  const std::vector<Eigen::Matrix3d> blocks = InverseDiagonal(layout.structure, equations.H, columns);
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    for (const int target : *targets[k]) report.covariances[target].covariance = blocks[k];
  }
  return absl::OkStatus();
}

void ReportEdges(const SolveOptions& options, const PoseGraph& graph, SolveReport& report) {
  std::unordered_map<std::int64_t, const Pose2*> poses;
  for (const PoseGraphNode& node : graph.nodes) poses.emplace(node.id, &node.T_world_node);
  for (const PoseGraphEdge& edge : graph.edges) {
    const Eigen::Vector3d e = EdgeError(*poses.at(edge.from), *poses.at(edge.to), EdgeMeasurement(edge.T_from_to));
    const double squared_error = e.dot(edge.information * e);
    const double weight = edge.robust ? Evaluate(options.kernel, squared_error).weight : 1.0;
    report.edge_chi2.push_back(squared_error);
    report.edge_weight.push_back(edge.enabled ? weight : 0.0);
  }
}

}  // namespace

absl::StatusOr<SolveReport> SolvePoseGraph(const SolveOptions& options, PoseGraph& graph) {
  ENFILADE_RETURN_IF_ERROR(Check(options));
  ENFILADE_ASSIGN_OR_RETURN(std::vector<IndexedGraph> components, IndexComponents(graph, options.fixed));
  ENFILADE_ASSIGN_OR_RETURN(const auto wanted, WantedCovariances(options, graph));
  SolveReport report;
  report.converged = true;
  report.components = static_cast<int>(components.size());
  for (const std::int64_t id : options.covariance_of) report.covariances.push_back({id, Eigen::Matrix3d::Zero()});
  for (IndexedGraph& component : components) {
    const GraphLayout layout = LayOut(component);
    report.initial_chi2 += GraphCost(component, component.poses, {});
    report.initial_cost += GraphCost(component, component.poses, options.kernel);
    const Minimum minimum = SolveComponent(options, layout, component);
    report.iterations += minimum.iterations;
    report.converged = report.converged && minimum.converged;
    report.final_cost += minimum.cost;
    report.final_chi2 += GraphCost(component, component.poses, {});
    ENFILADE_RETURN_IF_ERROR(AddCovariances(options, wanted, layout, component, report));
  }
  for (const IndexedGraph& component : components) {
    for (std::size_t i = 0; i < component.poses.size(); ++i) {
      graph.nodes[component.sources[i]].T_world_node = component.poses[i];
    }
  }
  ReportEdges(options, graph, report);
  return report;
}

}  // namespace enfilade::optimize
