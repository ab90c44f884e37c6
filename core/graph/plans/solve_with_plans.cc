// SPDX-License-Identifier: Apache-2.0
#include "core/graph/plans/solve_with_plans.h"

#include <algorithm>
#include <numeric>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "core/base/status_macros.h"
#include "core/graph/chi_squared.h"
#include "core/graph/joint_graph.h"
#include "core/graph/plans/joint_plans.h"
#include "core/graph/plans/joint_shafts.h"
#include "core/graph/plans/plan_placement.h"
#include "core/graph/plans/plan_shares.h"
#include "core/optimize/edge_error.h"
#include "core/optimize/solve_pose_graph.h"
#include "fmt/core.h"

namespace enfilade::graph {
namespace {

constexpr double kHuberWidth = 2.0;
constexpr double kWidths[] = {10.0, 3.0, 2.45};
constexpr double kGate = 0.99;      // of sightings and struts
constexpr double kTolerance = 2.0;  // of chi-squared: the error of one corner strains all struts that meet there

// One attempt, with some of the plans.
class PlanSolve {
 public:
  PlanSolve(const GraphSnapshot& snapshot, const SolvedGraph& without, const GraphOptimizationOptions& options,
            const std::vector<const PlanInGraph*>& plans)
      : snapshot_(snapshot), without_(without), options_(options) {
    std::vector<PlacedSlot> starts = {{snapshot.MapSlot(snapshot.root()), Pose2()}};
    const std::vector<PlacedPlan> placed = PlacePlans(snapshot, without, plans);
    for (const auto& [plan, T_world_plan] : placed) {
      for (const MapInPlan& map : plan->ties->maps) {
        const int slot = snapshot.MapSlot(map.map);
        const auto is_start = [slot](const PlacedSlot& start) { return start.first == slot; };
        if (slot < 0 || without.map_poses.contains(map.map) || std::any_of(starts.begin(), starts.end(), is_start)) {
          continue;
        }
        starts.emplace_back(slot, T_world_plan * map.T_plan_map);
      }
    }
    joint_ = BuildJointGraph(snapshot, starts, options);
    for (std::size_t i = 0; i < joint_.maps; ++i) {
      const auto known = without.map_poses.find(MapAt(i));
      if (known != without.map_poses.end()) joint_.graph.nodes[i].T_world_node = known->second.pose;
    }
    ApplyUse();
    for (const auto& [plan, T_world_plan] : placed) Add(*plan, T_world_plan);
    AddShafts();
    begin_ = joint_.graph.nodes;
  }

  const std::vector<PlanPart>& parts() const { return parts_; }

  absl::Status Run() {
    ENFILADE_RETURN_IF_ERROR(Solve({.type = optimize::RobustKernel::Type::kHuber, .width = kHuberWidth}));
    for (const double width : kWidths) {
      ENFILADE_RETURN_IF_ERROR(Solve({.type = optimize::RobustKernel::Type::kDcs, .width = width}));
    }
    for (Judged& one : judged_) {
      if (Excess(one) > 1.0) Use(one, false);
    }
    for (int round = 0;; ++round) {
      ENFILADE_RETURN_IF_ERROR(Solve({}));
      if (round >= options_.max_rounds) return absl::OkStatus();
      if (!SwitchOffWorst() && !UseAgain() && !SwitchOffStretched()) return absl::OkStatus();
    }
  }

  // Those that may bend what link points have measured: between plans that maps place. False: none is in use. What
  // agrees without them comes back when it is solved again.
  bool SwitchOffShafts() {
    bool any = false;
    for (Judged& one : judged_) {
      if (!one.is_tie_of_known) continue;
      any |= one.used;
      Use(one, false);
    }
    return any;
  }

  PlanUse UseOf(const PlanPart& part) const {
    PlanUse use{.plan = part.plan->id};
    for (std::size_t i = 0; i < part.edges.size(); ++i) {
      use.sightings.push_back(UseOf(part, i));
      if (use.sightings.back().is_part) ++(use.sightings.back().used ? use.used : use.switched_off);
    }
    if (use.used < use.switched_off) {
      use.contradiction =
          fmt::format("{} of {} walls that maps have seen do not fit", use.switched_off, use.used + use.switched_off);
    }
    const Strain strain = StrainOf(part);
    if (use.contradiction.empty() && strain.chi2 > strain.limit) {
      use.contradiction =
          fmt::format("it would have to be bent too much: chi-squared {:.0f} of {} degrees of freedom, at most {:.0f}",
                      strain.chi2, strain.degrees_of_freedom, strain.limit);
    }
    const auto index = static_cast<std::size_t>(&part - parts_.data());
    use.shafts = graph::UsesOf(joint_, shafts_, parts_, report_.edge_chi2, index);
    if (use.contradiction.empty()) use.contradiction = ContradictionOfShafts(use.shafts);
    return use;
  }

  // What link points say of the poses that the plans ask for; empty: they agree.
  std::string DisagreementOfLinkPoints() const {
    double chi2 = 0.0;
    int degrees_of_freedom = 0;
    for (const Judged& one : known_) {
      if (!one.used) continue;
      chi2 += Chi2(one);
      degrees_of_freedom += one.degrees_of_freedom;
    }
    if (degrees_of_freedom == 0) return "";
    const double limit = std::max(ChiSquaredQuantile(0.999, degrees_of_freedom), 1.1 * without_.chi2_after);
    if (chi2 <= limit) return "";
    return fmt::format("link points disagree with it: chi-squared {:.1f} of {} degrees of freedom, at most {:.1f}",
                       chi2, degrees_of_freedom, limit);
  }

  absl::StatusOr<SolvedGraph> Solution() {
    SolvedGraph solution = without_;
    const std::vector<char> is_joined = JoinedNodes(joint_);
    std::size_t nodes = 0;  // that are posed
    for (std::size_t i = 0; i < joint_.graph.nodes.size(); ++i) nodes += is_joined[i] != 0 ? 1 : 0;
    for (std::size_t i = 0; i < joint_.maps; ++i) {
      std::optional<Eigen::Matrix3d> covariance = report_.covariances[i].covariance;
      if (!without_.map_poses.contains(MapAt(i))) covariance = CovarianceByPlan(*covariance);
      if (is_joined[i] == 0 || !covariance) continue;
      solution.map_poses[MapAt(i)] = {joint_.graph.nodes[i].T_world_node, *covariance};
    }
    std::erase_if(solution.disconnected, [&](const MapId& map) { return solution.map_poses.contains(map); });
    for (const Judged& one : judged_) {
      if (one.link_point < 0 || one.used) continue;
      ENFILADE_ASSIGN_OR_RETURN(const double chi2, Disagreement(joint_, joint_.graph.nodes, joint_.terms[one.term]));
      solution.switched_off.push_back(
          {.link_point = snapshot_.link_point_node(one.link_point).link_point->id, .chi2 = chi2, .gate = one.gate});
    }
    std::sort(solution.switched_off.begin(), solution.switched_off.end(),
              [](const SwitchedOff& a, const SwitchedOff& b) { return a.link_point < b.link_point; });
    const auto shares_of = joint_.node_of.find(snapshot_.MapSlot(options_.shares_of));
    if (shares_of != joint_.node_of.end() && is_joined[shares_of->second] != 0) {
      ENFILADE_ASSIGN_OR_RETURN(solution.plan_shares, SharesOf(joint_, parts_, shafts_, shares_of->second));
    }
    solution.chi2_before = 0.0;
    solution.degrees_of_freedom = -3 * (static_cast<int>(nodes) - 1);
    for (std::size_t i = 0; i < joint_.graph.edges.size(); ++i) {
      const optimize::PoseGraphEdge& edge = joint_.graph.edges[i];
      if (!edge.enabled || is_joined[joint_.node_of.at(edge.from)] == 0) continue;
      solution.chi2_before += Chi2At(begin_, edge);
      solution.degrees_of_freedom += degrees_of_freedom_[i];
    }
    solution.chi2_after = report_.final_chi2;
    solution.iterations += iterations_;
    solution.converged = report_.converged;
    return solution;
  }

 private:
  // What may be switched off: a sighting, a strut, the tie of two shafts, or a link point.
  struct Judged {
    std::vector<std::size_t> edges = {};
    int degrees_of_freedom = 0;
    double gate = 0.0;
    int link_point = -1;   // slot; -1: it is none
    std::size_t term = 0;  // of the link point
    bool used = true;
    bool returned = false;
    bool is_tie_of_known = false;  // a tie of two shafts, of plans that maps place
  };

  SightingUse UseOf(const PlanPart& part, std::size_t sighting) const {
    const std::size_t edge = part.edges[sighting];
    if (edge == PlanPart::kNone) return {};
    const WallSighting& seen = part.ties().sightings[sighting];
    const auto pose = [&](std::int64_t id) { return joint_.graph.nodes[joint_.node_of.at(id)].T_world_node; };
    const Pose2 T_map_strut = Between(pose(joint_.graph.edges[edge].from), pose(joint_.graph.edges[edge].to));
    const Pose2 T_line_wall = Between(seen.T_map_line, T_map_strut * Pose2{seen.along, 0.0, 0.0});
    return {.is_part = true,
            .used = joint_.graph.edges[edge].enabled,
            .across = T_line_wall.y,
            .turn = T_line_wall.yaw,
            .chi2 = report_.edge_chi2[edge]};
  }

  // How much a plan is bent: of all struts, also those that are switched off, and the sightings that count.
  struct Strain {
    double chi2 = 0.0;  // single struts count up to twice their gate: a wall may be elsewhere than it is drawn
    int degrees_of_freedom = 0;
    double limit = 0.0;
  };
  Strain StrainOf(const PlanPart& part) const {
    Strain strain;
    const auto most = 2.0 * ChiSquaredQuantile(kGate, 3);
    for (const std::size_t edge : part.strut_edges) strain.chi2 += std::min(report_.edge_chi2[edge], most);
    auto freedom = 3 * static_cast<std::ptrdiff_t>(part.strut_edges.size()) -
                   3 * static_cast<std::ptrdiff_t>(part.corners.size() + part.seen_struts.size());
    for (const std::size_t edge : part.edges) {
      if (edge == PlanPart::kNone || !joint_.graph.edges[edge].enabled) continue;
      strain.chi2 += report_.edge_chi2[edge];
      freedom += 2;
    }
    for (const MapInPlan& map : part.ties().maps) freedom -= without_.map_poses.contains(map.map) ? 0 : 3;
    strain.degrees_of_freedom = static_cast<int>(std::max<std::ptrdiff_t>(freedom, 1));
    strain.limit = kTolerance * ChiSquaredQuantile(0.999, strain.degrees_of_freedom);
    return strain;
  }

  const MapId& MapAt(std::size_t node) const {
    return snapshot_.map_node(static_cast<int>(joint_.graph.nodes[node].id)).map->id;
  }

  void Add(const PlanInGraph& plan, const Pose2& T_world_plan) {
    parts_.push_back(AddPlan(snapshot_, plan, T_world_plan, joint_));
    degrees_of_freedom_.resize(joint_.graph.edges.size(), 3);
    for (const std::size_t edge : parts_.back().edges) {
      if (edge == PlanPart::kNone) continue;
      degrees_of_freedom_[edge] = 2;
      judged_.push_back({.edges = {edge}, .degrees_of_freedom = 2, .gate = ChiSquaredQuantile(kGate, 2)});
    }
    for (const std::size_t edge : parts_.back().strut_edges) {
      judged_.push_back({.edges = {edge}, .degrees_of_freedom = 3, .gate = ChiSquaredQuantile(kGate, 3)});
    }
  }

  void AddShafts() {
    shafts_ = graph::AddShafts(snapshot_, parts_, joint_);
    degrees_of_freedom_.resize(joint_.graph.edges.size(), 3);
    for (const ShaftNode& shaft : shafts_.nodes) {  // together its edges are one measurement of a pose
      for (std::size_t i = 1; i < shaft.edges.size(); ++i) degrees_of_freedom_[shaft.edges[i]] = 0;
    }
    const double gate = ChiSquaredQuantile(kGate, 3);
    for (const ShaftTie& tie : shafts_.ties) {
      const bool known = IsKnown(shafts_.nodes[tie.a].part) && IsKnown(shafts_.nodes[tie.b].part);
      judged_.push_back({.edges = {tie.edge}, .degrees_of_freedom = 3, .gate = gate, .is_tie_of_known = known});
    }
  }
  // Whether a map that is posed without plans has seen the part.
  bool IsKnown(std::size_t part) const {
    const std::vector<MapInPlan>& maps = parts_[part].ties().maps;
    return std::any_of(maps.begin(), maps.end(), [&](const auto& map) { return without_.map_poses.contains(map.map); });
  }

  // Link points between maps that are posed without plans count as they do there; others are judged.
  void ApplyUse() {
    for (std::size_t i = 0; i < joint_.terms.size(); ++i) {
      const JointTerm& term = joint_.terms[i];
      const LinkPoint& link_point = *snapshot_.link_point_node(term.link_point).link_point;
      Judged one{.edges = term.edges,
                 .degrees_of_freedom = term.degrees_of_freedom,
                 .gate = ChiSquaredQuantile(options_.gate_probability, term.degrees_of_freedom),
                 .link_point = term.link_point,
                 .term = i};
      const bool is_known = std::all_of(link_point.anchors.begin(), link_point.anchors.end(),
                                        [&](const Anchor& anchor) { return without_.map_poses.contains(anchor.map); });
      one.used = std::none_of(without_.switched_off.begin(), without_.switched_off.end(),
                              [&](const SwitchedOff& off) { return off.link_point == link_point.id; });
      SetEnabled(joint_, term, one.used);
      for (const std::size_t edge : term.edges) joint_.graph.edges[edge].robust = !is_known;
      (is_known ? known_ : judged_).push_back(std::move(one));
    }
    degrees_of_freedom_.assign(joint_.graph.edges.size(), 3);
  }

  absl::Status Solve(const optimize::RobustKernel& kernel) {
    ENFILADE_ASSIGN_OR_RETURN(report_, SolveJointGraph(options_, kernel, optimize::Initialisation::kNone, joint_));
    iterations_ += report_.iterations;
    return absl::OkStatus();
  }

  double Chi2(const Judged& one) const {
    return std::accumulate(one.edges.begin(), one.edges.end(), 0.0,
                           [this](double sum, std::size_t edge) { return sum + report_.edge_chi2[edge]; });
  }
  // Comparable between sightings, struts and link points.
  double Excess(const Judged& one) const { return Chi2(one) / one.gate; }

  void Use(Judged& one, bool used) {
    one.used = used;
    for (const std::size_t edge : one.edges) joint_.graph.edges[edge].enabled = used;
  }

  bool SwitchOffWorst() {
    const auto worst = std::max_element(judged_.begin(), judged_.end(), [this](const Judged& a, const Judged& b) {
      return (a.used ? Excess(a) : 0.0) < (b.used ? Excess(b) : 0.0);
    });
    if (worst == judged_.end() || !worst->used || Excess(*worst) <= 1.0) return false;
    Use(*worst, false);
    return true;
  }

  // Sightings around walls that would be stretched too much, for good, so that the rounds end.
  bool SwitchOffStretched() {
    std::set<std::size_t> doubtful;
    for (const PlanPart& part : parts_) doubtful.merge(EdgesAroundStretched(joint_, part));
    bool any = false;
    for (Judged& one : judged_) {
      if (!one.used || !doubtful.contains(one.edges.front())) continue;
      one.returned = true;
      Use(one, false);
      any = true;
    }
    return any;
  }

  // At most once each, so that the rounds end.
  bool UseAgain() {
    bool any = false;
    for (Judged& one : judged_) {
      if (one.used || one.returned || Excess(one) > 1.0) continue;
      one.returned = true;
      Use(one, true);
      any = true;
    }
    return any;
  }

  double Chi2At(const std::vector<optimize::PoseGraphNode>& nodes, const optimize::PoseGraphEdge& edge) const {
    const Eigen::Vector3d error =
        optimize::EdgeError(nodes[joint_.node_of.at(edge.from)].T_world_node,
                            nodes[joint_.node_of.at(edge.to)].T_world_node, optimize::EdgeMeasurement(edge.T_from_to));
    return error.dot(edge.information * error);
  }

  const GraphSnapshot& snapshot_;
  const SolvedGraph& without_;
  const GraphOptimizationOptions& options_;
  JointGraph joint_;
  std::vector<PlanPart> parts_;
  JointShafts shafts_;
  std::vector<int> degrees_of_freedom_;  // of each edge
  std::vector<Judged> known_;            // link points
  std::vector<Judged> judged_;
  std::vector<optimize::PoseGraphNode> begin_;
  optimize::SolveReport report_;
  int iterations_ = 0;
};

double ShareOf(const PlanUse& use) { return static_cast<double>(use.used) / (use.used + use.switched_off); }

}  // namespace

absl::StatusOr<SolvedGraph> SolveWithPlans(const GraphSnapshot& graph, SolvedGraph without,
                                           const GraphOptimizationOptions& options) {
  std::vector<const PlanInGraph*> plans;
  std::vector<PlanUse> uses;  // of those that are decided
  for (const PlanInGraph& plan : graph.plans()) plans.push_back(&plan);
  const auto finish = [&](SolvedGraph solution) {
    solution.plans = std::move(uses);
    std::sort(solution.plans.begin(), solution.plans.end(),
              [](const PlanUse& a, const PlanUse& b) { return a.plan < b.plan; });
    return solution;
  };
  while (true) {
    PlanSolve solve(graph, without, options, plans);
    std::erase_if(plans, [&](const PlanInGraph* plan) {
      const bool is_part = std::any_of(solve.parts().begin(), solve.parts().end(),
                                       [&](const PlanPart& part) { return part.plan == plan; });
      if (!is_part) uses.push_back({.plan = plan->id});  // no map that is posed has seen it
      return !is_part;
    });
    if (plans.empty()) return finish(std::move(without));
    ENFILADE_RETURN_IF_ERROR(solve.Run());
    if (!solve.DisagreementOfLinkPoints().empty() && solve.SwitchOffShafts()) ENFILADE_RETURN_IF_ERROR(solve.Run());
    std::vector<PlanUse> attempted;
    for (const PlanPart& part : solve.parts()) attempted.push_back(solve.UseOf(part));
    const auto is_contradicted = [](const PlanUse& use) { return !use.contradiction.empty(); };
    if (std::none_of(attempted.begin(), attempted.end(), is_contradicted)) {
      const std::string disagreement = solve.DisagreementOfLinkPoints();
      if (disagreement.empty()) {
        ENFILADE_ASSIGN_OR_RETURN(SolvedGraph solution, solve.Solution());
        uses.insert(uses.end(), attempted.begin(), attempted.end());
        return finish(std::move(solution));
      }
      std::min_element(attempted.begin(), attempted.end(), [](const PlanUse& a, const PlanUse& b) {
        return ShareOf(a) < ShareOf(b);
      })->contradiction = disagreement;
    }
    for (const PlanUse& use : attempted) {
      if (!is_contradicted(use)) continue;
      uses.push_back(use);
      std::erase_if(plans, [&](const PlanInGraph* plan) { return plan->id == use.plan; });
    }
    if (plans.empty()) return finish(std::move(without));
  }
}

}  // namespace enfilade::graph
