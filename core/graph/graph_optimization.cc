// SPDX-License-Identifier: Apache-2.0
#include "core/graph/graph_optimization.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

#include "core/base/disjoint_sets.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/graph/chi_squared.h"
#include "core/graph/joint_graph.h"
#include "core/graph/plans/solve_with_plans.h"
#include "core/optimize/solve_pose_graph.h"

namespace enfilade::graph {
namespace {

// False if all of `maps` were already joined.
template <typename Maps>
bool JoinAll(const Maps& maps, DisjointSets& islands) {
  bool joined = false;
  for (const int map : maps) {
    joined |= islands.Join(static_cast<std::size_t>(maps.front()), static_cast<std::size_t>(map));
  }
  return joined;
}

class Optimization {
 public:
  Optimization(const GraphSnapshot& snapshot, int root, const GraphOptimizationOptions& options)
      : snapshot_(snapshot), options_(options), joint_(BuildJointGraph(snapshot, root, options)) {
    begin_ = joint_.graph.nodes;
    used_.assign(joint_.terms.size(), 1);
    returned_.assign(joint_.terms.size(), 0);
    chi2_.assign(joint_.terms.size(), 0.0);
    std::map<int, double> gates;
    for (const JointTerm& term : joint_.terms) {
      const auto [gate, is_new] = gates.try_emplace(term.degrees_of_freedom);
      if (is_new) gate->second = ChiSquaredQuantile(options.gate_probability, term.degrees_of_freedom);
      gate_.push_back(gate->second);
    }
  }

  absl::StatusOr<SolvedGraph> Run() {
    ENFILADE_RETURN_IF_ERROR(SolveRobustly());
    SwitchOffBeyondGate();
    for (int round = 0;; ++round) {
      ENFILADE_RETURN_IF_ERROR(Solve({}, optimize::Initialisation::kNone));
      if (round >= options_.max_rounds) break;
      ENFILADE_RETURN_IF_ERROR(JudgeUnused());
      if (!SwitchOffWorst() && !UseAgain()) break;
    }
    return Solution();
  }

 private:
  // A kernel that ignores large errors has local minima in which one wrong link point outweighs several right ones;
  // which minimum is found depends on the start. Huber's kernel finds the majority's minimum, slightly biased. So start
  // there and elsewhere and keep the smaller minimum.
  absl::Status SolveRobustly() {
    const optimize::RobustKernel dcs{.type = optimize::RobustKernel::Type::kDcs, .width = options_.kernel_width};
    ENFILADE_RETURN_IF_ERROR(
        Solve({.type = optimize::RobustKernel::Type::kHuber, .width = 1.0}, optimize::Initialisation::kAuto));
    ENFILADE_RETURN_IF_ERROR(Solve(dcs, optimize::Initialisation::kNone));
    const double cost = report_.final_cost;
    const std::vector<optimize::PoseGraphNode> nodes = joint_.graph.nodes;
    ENFILADE_RETURN_IF_ERROR(Solve(dcs, optimize::Initialisation::kAuto));
    if (report_.final_cost < cost) return absl::OkStatus();
    joint_.graph.nodes = nodes;
    return Solve(dcs, optimize::Initialisation::kNone);
  }

  absl::Status Solve(const optimize::RobustKernel& kernel, optimize::Initialisation initialisation) {
    ENFILADE_ASSIGN_OR_RETURN(report_, SolveJointGraph(options_, kernel, initialisation, joint_));
    iterations_ += report_.iterations;
    for (std::size_t i = 0; i < joint_.terms.size(); ++i) {
      chi2_[i] = 0.0;
      for (const std::size_t edge : joint_.terms[i].edges) chi2_[i] += report_.edge_chi2[edge];
    }
    return absl::OkStatus();
  }

  // chi-squared relative to the gate: comparable between link points with different numbers of anchors.
  double Excess(std::size_t term) const { return chi2_[term] / gate_[term]; }

  const auto& MapsOf(std::size_t term) const { return snapshot_.link_point_node(joint_.terms[term].link_point).maps; }

  void Use(std::size_t term, bool used) {
    used_[term] = used ? 1 : 0;
    SetEnabled(joint_, joint_.terms[term], used);
  }

  // In order of quality, keeps link points that join maps which no better ones join.
  void SwitchOffBeyondGate() {
    std::vector<std::size_t> order(joint_.terms.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [this](auto a, auto b) { return Excess(a) < Excess(b); });
    DisjointSets islands(snapshot_.map_slots());
    for (const std::size_t term : order) {
      const bool needed = JoinAll(MapsOf(term), islands);
      if (Excess(term) > 1.0 && !needed) Use(term, false);
    }
  }

  // Whether the maps of `term` would be disconnected without it.
  bool IsNeeded(std::size_t term) const {
    DisjointSets islands(snapshot_.map_slots());
    for (std::size_t i = 0; i < joint_.terms.size(); ++i) {
      if (i != term && used_[i] != 0) JoinAll(MapsOf(i), islands);
    }
    return JoinAll(MapsOf(term), islands);
  }

  bool SwitchOffWorst() {
    std::vector<std::size_t> beyond;
    for (std::size_t i = 0; i < joint_.terms.size(); ++i) {
      if (used_[i] != 0 && Excess(i) > 1.0) beyond.push_back(i);
    }
    std::stable_sort(beyond.begin(), beyond.end(), [this](auto a, auto b) { return Excess(a) > Excess(b); });
    for (const std::size_t term : beyond) {
      if (IsNeeded(term)) continue;
      Use(term, false);
      return true;
    }
    return false;
  }

  absl::Status JudgeUnused() {
    for (std::size_t i = 0; i < joint_.terms.size(); ++i) {
      if (used_[i] != 0) continue;
      ENFILADE_ASSIGN_OR_RETURN(chi2_[i], Disagreement(joint_, joint_.graph.nodes, joint_.terms[i]));
    }
    return absl::OkStatus();
  }

  // At most once for each link point, so that the rounds end.
  bool UseAgain() {
    bool any = false;
    for (std::size_t i = 0; i < joint_.terms.size(); ++i) {
      if (used_[i] != 0 || returned_[i] != 0 || Excess(i) > 1.0) continue;
      returned_[i] = 1;
      Use(i, true);
      any = true;
    }
    return any;
  }

  absl::StatusOr<SolvedGraph> Solution() {
    ENFILADE_RETURN_IF_ERROR(JudgeUnused());
    SolvedGraph solution{.graph_version = snapshot_.version(), .root = snapshot_.root()};
    for (std::size_t i = 0; i < joint_.maps; ++i) {
      const optimize::PoseGraphNode& node = joint_.graph.nodes[i];
      solution.map_poses[snapshot_.map_node(static_cast<int>(node.id)).map->id] = {node.T_world_node,
                                                                                   report_.covariances[i].covariance};
    }
    solution.degrees_of_freedom = -3 * (static_cast<int>(joint_.maps) - 1);
    for (std::size_t i = 0; i < joint_.terms.size(); ++i) {
      if (used_[i] != 0) {
        solution.degrees_of_freedom += joint_.terms[i].degrees_of_freedom;
        ENFILADE_ASSIGN_OR_RETURN(const double before, Disagreement(joint_, begin_, joint_.terms[i]));
        solution.chi2_before += before;
        solution.chi2_after += chi2_[i];
      } else {
        const LinkPoint& link_point = *snapshot_.link_point_node(joint_.terms[i].link_point).link_point;
        solution.switched_off.push_back({.link_point = link_point.id, .chi2 = chi2_[i], .gate = gate_[i]});
      }
    }
    SwitchOffUnusable(solution);
    solution.disconnected = joint_.disconnected;
    solution.iterations = iterations_;
    solution.converged = report_.converged;
    return solution;
  }

  void SwitchOffUnusable(SolvedGraph& solution) const {
    for (const LinkPoint* link_point : snapshot_.ListLinkPoints()) {
      if (link_point->use == LinkPointUse::kSuspended || link_point->is_candidate()) continue;
      if (IsUnusable(*link_point)) solution.switched_off.push_back({.link_point = link_point->id});
    }
    std::sort(solution.switched_off.begin(), solution.switched_off.end(),
              [](const SwitchedOff& a, const SwitchedOff& b) { return a.link_point < b.link_point; });
  }

  const GraphSnapshot& snapshot_;
  const GraphOptimizationOptions& options_;
  JointGraph joint_;
  std::vector<optimize::PoseGraphNode> begin_;
  std::vector<char> used_;      // per term
  std::vector<char> returned_;  // per term
  std::vector<double> gate_;    // per term
  std::vector<double> chi2_;    // per term
  optimize::SolveReport report_;
  int iterations_ = 0;
};

absl::Status Validate(const GraphOptimizationOptions& options) {
  if (!(options.gate_probability > 0.0 && options.gate_probability < 1.0)) {
    return InvalidArgument("gate_probability is {}: it must lie between 0 and 1", options.gate_probability);
  }
  if (!(options.kernel_width > 0.0) || !std::isfinite(options.kernel_width)) {
    return InvalidArgument("kernel_width is {}: it must be positive", options.kernel_width);
  }
  if (!(options.position_floor_m > 0.0 && options.yaw_floor_rad > 0.0)) {
    return InvalidArgument("position_floor_m and yaw_floor_rad must be positive");
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<SolvedGraph> OptimizeGraph(const GraphSnapshot& graph, const GraphOptimizationOptions& options) {
  ENFILADE_RETURN_IF_ERROR(Validate(options));
  const int root = graph.MapSlot(graph.root());
  if (root < 0) return FailedPrecondition("the graph has no maps");
  ENFILADE_ASSIGN_OR_RETURN(SolvedGraph solution, Optimization(graph, root, options).Run());
  return graph.plans().empty() ? std::move(solution) : SolveWithPlans(graph, std::move(solution), options);
}

SnapshotChanges ChangesOf(const GraphSnapshot& graph, SolvedGraph solution, std::int64_t version) {
  SnapshotChanges changes{.version = version};
  for (const LinkPoint* link_point : graph.ListLinkPoints()) {
    if (link_point->use == LinkPointUse::kSuspended) continue;
    const bool off = std::any_of(solution.switched_off.begin(), solution.switched_off.end(),
                                 [link_point](const SwitchedOff& s) { return s.link_point == link_point->id; });
    const LinkPointUse use = off ? LinkPointUse::kSwitchedOff : LinkPointUse::kUsed;
    if (use == link_point->use) continue;
    changes.link_points.push_back(*link_point);
    changes.link_points.back().use = use;
    changes.link_points.back().graph_version = version;
  }
  changes.solution = std::make_shared<const SolvedGraph>(std::move(solution));
  return changes;
}

}  // namespace enfilade::graph
