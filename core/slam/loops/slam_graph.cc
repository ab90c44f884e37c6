// SPDX-License-Identifier: Apache-2.0
#include "core/slam/loops/slam_graph.h"

#include <Eigen/Dense>
#include <cmath>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/optimize/solve_pose_graph.h"
#include "core/slam/loops/edge_information.h"
#include "fmt/format.h"

namespace enfilade::slam {
namespace {

std::int64_t SubmapVertex(std::int64_t submap) { return 2 * submap; }
std::int64_t NodeVertex(std::int64_t node) { return 2 * node + 1; }

bool IsInGraph(const LoopClosure& closure) {
  return closure.state != LoopClosureState::kSuspended && !closure.information.isZero();
}

struct Problem {
  optimize::PoseGraph graph;
  std::map<std::size_t, std::int64_t> ties;  // edges to the next submap, and the id of their first
  std::set<std::size_t> stated;       // edges whose covariance is stated, not measured: to the existing map, while lost
  std::set<std::int64_t> free_nodes;  // keyframes with a vertex
  std::vector<std::int64_t> closures;  // ids of the edges from `first_closure` on
  std::size_t first_closure = 0;
};

Pose2 PoseOfSubmap(const MapperState& state, std::int64_t id) {
  return state.active && state.active->id == id ? state.active->T_map_submap : state.finished.at(id).T_map_submap;
}

void AddSubmap(std::int64_t id, const Pose2& pose, const std::vector<SubmapNode>& nodes, Problem& problem) {
  problem.graph.nodes.push_back({SubmapVertex(id), pose});
  for (const SubmapNode& node : nodes) {
    if (node.carried || !problem.free_nodes.contains(node.node)) continue;
    problem.graph.edges.push_back({SubmapVertex(id), NodeVertex(node.node), node.T_submap_node,
                                   InMeasurementFrame(node.information, node.T_submap_node.yaw), false, true});
  }
}

// `free_nodes`: keyframes that shall have a vertex in any case.
Problem BuildProblem(const MapperState& state, std::set<std::int64_t> free_nodes) {
  Problem problem;
  problem.free_nodes = std::move(free_nodes);
  for (const auto& [id, closure] : state.loop_closures) {
    if (IsInGraph(closure)) problem.free_nodes.insert(closure.node);
  }
  for (const auto& [id, submap] : state.finished) AddSubmap(id, submap.T_map_submap, submap.nodes, problem);
  if (state.active) AddSubmap(state.active->id, state.active->T_map_submap, state.active->content.nodes, problem);
  for (const std::int64_t id : problem.free_nodes) {
    problem.graph.nodes.push_back({NodeVertex(id), state.nodes.at(id).T_map_node});
  }
  for (const auto& [id, submap] : state.finished) {
    if (!submap.next) continue;
    problem.ties[problem.graph.edges.size()] = id;
    if (!IsMeasured(state, id, *submap.next)) problem.stated.insert(problem.graph.edges.size());
    problem.graph.edges.push_back({SubmapVertex(id), SubmapVertex(id + 1), submap.next->T_submap_next,
                                   InMeasurementFrame(submap.next->information, submap.next->T_submap_next.yaw), false,
                                   true});
  }
  problem.first_closure = problem.graph.edges.size();
  for (const auto& [id, closure] : state.loop_closures) {
    if (!IsInGraph(closure)) continue;
    problem.closures.push_back(id);
    problem.graph.edges.push_back({SubmapVertex(closure.submap), NodeVertex(closure.node), closure.T_submap_node,
                                   InMeasurementFrame(closure.information, closure.T_submap_node.yaw), true, true});
  }
  return problem;
}

// Accepts or rejects the loop closures by their chi2 in the robust solution.
void JudgeLoopClosures(const optimize::SolveReport& report, const GraphOptions& options, MapperState& state,
                       Problem& problem, GraphChange& change) {
  for (std::size_t i = 0; i < problem.closures.size(); ++i) {
    optimize::PoseGraphEdge& edge = problem.graph.edges[problem.first_closure + i];
    LoopClosure& closure = state.loop_closures.at(problem.closures[i]);
    const double chi2 = report.edge_chi2[problem.first_closure + i];
    const bool valid = chi2 < options.max_chi2;
    edge.robust = false;
    edge.enabled = valid;
    const LoopClosureState judged = valid ? LoopClosureState::kAccepted : LoopClosureState::kRejected;
    if (closure.state == judged) continue;
    closure.state = judged;
    closure.reason = valid ? fmt::format("fits the pose graph again: inlier share {:.2f}", closure.score)
                           : fmt::format("chi2 {:.1f} in the pose graph, more than {:.1f}", chi2, options.max_chi2);
    change.loop_closures.insert(closure.id);
  }
}

// Counts how far the measurements are from the solution.
void CountErrors(const optimize::SolveReport& report, const Problem& problem, MapperState& state) {
  state.errors.graph_chi2 = 0.0;
  state.errors.redundancy = 0;
  for (std::size_t i = 0; i < problem.graph.edges.size(); ++i) {
    if (problem.graph.edges[i].enabled && !problem.stated.contains(i)) state.errors.graph_chi2 += report.edge_chi2[i];
    if (problem.graph.edges[i].enabled && i >= problem.first_closure) state.errors.redundancy += 3;
  }
}

// The covariances of the vertices `wanted` relative to `fixed`, in the map frame, without kernel. The poses must be
// solved.
absl::StatusOr<std::map<std::int64_t, Eigen::Matrix3d>> CovariancesOf(const MapperState& state, Problem problem,
                                                                      std::int64_t fixed,
                                                                      std::vector<std::int64_t> wanted) {
  const double factor = VarianceFactor(state.errors);
  for (std::size_t i = 0; i < problem.graph.edges.size(); ++i) {
    problem.graph.edges[i].robust = false;
    if (!problem.stated.contains(i)) problem.graph.edges[i].information /= factor;
  }
  optimize::SolveOptions solve;
  solve.initialisation = optimize::Initialisation::kNone;
  solve.max_iterations = 0;
  solve.fixed = {fixed};
  solve.covariance_of = std::move(wanted);
  ENFILADE_ASSIGN_OR_RETURN(const optimize::SolveReport report, optimize::SolvePoseGraph(solve, problem.graph));
  std::map<std::int64_t, Eigen::Matrix3d> covariances;
  for (const optimize::NodeCovariance& c : report.covariances) covariances[c.id] = c.covariance;
  return covariances;
}

// Copies the solution into the state.
void UpdateState(const optimize::SolveReport& report, const Problem& problem,
                 std::map<std::int64_t, Eigen::Matrix3d> covariances, MapperState& state, GraphChange& change) {
  std::map<std::int64_t, Pose2> poses;
  for (const optimize::PoseGraphNode& vertex : problem.graph.nodes) poses[vertex.id] = vertex.T_world_node;
  const double factor = VarianceFactor(state.errors);

  const auto put = [&](std::int64_t id, Pose2& T_map_submap, const std::vector<SubmapNode>& nodes) {
    const Pose2& pose = poses.at(SubmapVertex(id));
    if (!(pose == T_map_submap)) change.submaps.insert(id);
    T_map_submap = pose;
    for (const SubmapNode& measured : nodes) {
      if (measured.carried) continue;
      SlamNode& node = state.nodes.at(measured.node);
      const SlamNode before = node;
      if (problem.free_nodes.contains(node.id)) {
        node.T_map_node = poses.at(NodeVertex(node.id));
        node.covariance = covariances[NodeVertex(node.id)];
      } else {
        const Eigen::Matrix3d own = measured.information.inverse();
        const PoseWithCovariance composed = Compose({pose, covariances[SubmapVertex(id)]},
                                                    {measured.T_submap_node, 0.5 * factor * (own + own.transpose())});
        node.T_map_node = composed.pose;
        node.covariance = composed.covariance;
      }
      if (!(node == before)) change.nodes.insert(node.id);
    }
  };
  for (auto& [id, submap] : state.finished) put(id, submap.T_map_submap, submap.nodes);
  if (state.active) put(state.active->id, state.active->T_map_submap, state.active->content.nodes);
  for (std::size_t i = 0; i < problem.closures.size(); ++i) {
    LoopClosure& closure = state.loop_closures.at(problem.closures[i]);
    const double chi2 = report.edge_chi2[problem.first_closure + i];
    if (closure.chi2 == chi2) continue;
    closure.chi2 = chi2;
    change.loop_closures.insert(closure.id);
  }
}

}  // namespace

GraphChange SolveSlamGraph(const GraphOptions& options, MapperState& state) {
  GraphChange change;
  if (state.nodes.empty()) return change;
  Problem problem = BuildProblem(state, state.entry ? std::set<std::int64_t>{} : std::set<std::int64_t>{0});
  optimize::SolveOptions solve;
  solve.initialisation = optimize::Initialisation::kNone;
  solve.kernel = {optimize::RobustKernel::Type::kCauchy, options.kernel_width};
  solve.max_iterations = options.max_iterations;
  const std::int64_t fixed = state.entry ? SubmapVertex(0) : NodeVertex(0);
  solve.fixed = {fixed};
  const absl::StatusOr<optimize::SolveReport> first = optimize::SolvePoseGraph(solve, problem.graph);
  if (!first.ok()) return change;
  JudgeLoopClosures(*first, options, state, problem, change);
  solve.kernel = {};
  const absl::StatusOr<optimize::SolveReport> second = optimize::SolvePoseGraph(solve, problem.graph);
  if (!second.ok()) return change;
  CountErrors(*second, problem, state);
  std::vector<std::int64_t> all;
  for (const optimize::PoseGraphNode& vertex : problem.graph.nodes) all.push_back(vertex.id);
  auto covariances = CovariancesOf(state, problem, fixed, std::move(all));
  if (!covariances.ok()) return change;
  UpdateState(*second, problem, *std::move(covariances), state, change);
  return change;
}

std::map<std::int64_t, Eigen::Matrix3d> LoosenTies(const GraphOptions& options, const std::set<std::int64_t>& trusted,
                                                   MapperState& state) {
  Problem problem = BuildProblem(state, state.entry ? std::set<std::int64_t>{} : std::set<std::int64_t>{0});
  for (std::size_t i = 0; i < problem.closures.size(); ++i) {
    optimize::PoseGraphEdge& edge = problem.graph.edges[problem.first_closure + i];
    const bool is_trusted = trusted.contains(problem.closures[i]);
    edge.robust = !is_trusted;
    edge.enabled = is_trusted || state.loop_closures.at(problem.closures[i]).state == LoopClosureState::kAccepted;
  }
  for (const auto& [edge, id] : problem.ties) problem.graph.edges[edge].robust = true;
  optimize::SolveOptions solve;
  solve.initialisation = optimize::Initialisation::kNone;
  solve.kernel = {optimize::RobustKernel::Type::kCauchy, options.kernel_width};
  solve.max_iterations = options.max_iterations;
  solve.fixed = {state.entry ? SubmapVertex(0) : NodeVertex(0)};
  const absl::StatusOr<optimize::SolveReport> report = optimize::SolvePoseGraph(solve, problem.graph);
  std::map<std::int64_t, Eigen::Matrix3d> loosened;
  if (!report.ok()) return loosened;
  for (const auto& [edge, id] : problem.ties) {
    const double chi2 = report->edge_chi2[edge];
    if (chi2 <= options.max_chi2 || problem.stated.contains(edge)) continue;
    loosened[id] = state.finished.at(id).next->information * (3.0 / chi2);
  }
  for (const optimize::PoseGraphNode& vertex : problem.graph.nodes) {
    const std::int64_t id = vertex.id / 2;
    if (vertex.id % 2 != 0) {
      state.nodes.at(id).T_map_node = vertex.T_world_node;
    } else if (state.active && state.active->id == id) {
      state.active->T_map_submap = vertex.T_world_node;
    } else {
      state.finished.at(id).T_map_submap = vertex.T_world_node;
    }
  }
  return loosened;
}

absl::StatusOr<std::vector<Eigen::Matrix3d>> RelativeCovariances(const MapperState& state, std::int64_t from,
                                                                 const std::vector<std::int64_t>& to) {
  std::set<std::int64_t> keyframes(to.begin(), to.end());
  keyframes.insert(from);
  for (const std::int64_t id : keyframes) {
    if (!state.nodes.contains(id)) return InvalidArgument("there is no keyframe {}", id);
  }
  Problem problem = BuildProblem(state, keyframes);
  for (std::size_t i = 0; i < problem.closures.size(); ++i) {
    problem.graph.edges[problem.first_closure + i].enabled =
        state.loop_closures.at(problem.closures[i]).state == LoopClosureState::kAccepted;
  }
  std::vector<std::int64_t> wanted;
  for (const std::int64_t id : keyframes) wanted.push_back(NodeVertex(id));
  ENFILADE_ASSIGN_OR_RETURN(const auto covariances,
                            CovariancesOf(state, std::move(problem), NodeVertex(from), std::move(wanted)));
  std::vector<Eigen::Matrix3d> result;
  const double yaw = state.nodes.at(from).T_map_node.yaw;
  for (const std::int64_t id : to) result.push_back(InMeasurementFrame(covariances.at(NodeVertex(id)), yaw));
  return result;
}

bool IsMeasured(const MapperState& state, std::int64_t id, const NextSubmap& next) {
  return !state.is_existing_map(id) && next.information != LostTie();
}

double LoopClosureChi2(const MapperState& state, const LoopClosure& closure) {
  const Pose2 T_submap_node = Between(PoseOfSubmap(state, closure.submap), state.nodes.at(closure.node).T_map_node);
  const Eigen::Vector3d e(T_submap_node.x - closure.T_submap_node.x, T_submap_node.y - closure.T_submap_node.y,
                          WrapAngle(T_submap_node.yaw - closure.T_submap_node.yaw));
  return e.dot(closure.information * e);
}

}  // namespace enfilade::slam
