// SPDX-License-Identifier: Apache-2.0
#include "core/graph/plans/joint_plans.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/median.h"

namespace enfilade::graph {
namespace {

constexpr double kTurnSigma = 1.0 * kDegree;  // of a strut
constexpr double kAlongSigma = 30.0;        // m: walls are not seen along themselves, but matrices must have an inverse
constexpr double kMostPositionSigma = 1.0;  // m
constexpr double kMostYawSigma = 5.0 * kDegree;  // rad
// Maps are taken to be rigid, but SLAM bends them a little: all walls of a map are off together.
constexpr double kBendingPosition = 0.03;      // m
constexpr double kBendingYaw = 0.2 * kDegree;  // rad
constexpr double kShortStrut = 2.0;            // m
constexpr double kLeastStretch = 0.7;
constexpr double kMostStretch = 1.4;

// Of one corner relative to another so far away, along the way there and across it: m^2.
Eigen::Vector2d CornerVariances(const PlanTies& ties, double length) {
  const double corners = 2.0 * ties.corner_sigma * ties.corner_sigma;
  const double stretch = ties.stretch_sigma * length;
  const double turn = kTurnSigma * length;
  return {corners + stretch * stretch, corners + turn * turn};
}

// Uncertainty of a strut between its corners, in its own frame: along, across (m^2), turn (rad^2).
Eigen::Vector3d StrutVariances(const PlanTies& ties, double length) {
  const Eigen::Vector2d variances = CornerVariances(ties, length);
  return {variances.x(), variances.y(), variances.y() / (length * length)};
}

// The information of a strut, in a frame in which it points to `direction`.
Eigen::Matrix3d StrutInformation(const Eigen::Vector3d& variances, double direction) {
  Eigen::Matrix3d to_frame = Eigen::Matrix3d::Identity();
  to_frame.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(direction).toRotationMatrix();
  const Eigen::Matrix3d information = to_frame * variances.cwiseInverse().asDiagonal() * to_frame.transpose();
  return 0.5 * (information + information.transpose());
}

// Of the line's direction, and of its place across where it was seen; in the frame of the strut's middle.
Eigen::Matrix3d SightingInformation(const WallSighting& sighting) {
  Eigen::Matrix3d jacobian = Eigen::Matrix3d::Identity();
  jacobian(1, 2) = sighting.along;
  const Eigen::Vector3d variances(kAlongSigma * kAlongSigma, sighting.across_sigma * sighting.across_sigma,
                                  sighting.yaw_sigma * sighting.yaw_sigma);
  const Eigen::Matrix3d information = jacobian.transpose() * variances.cwiseInverse().asDiagonal() * jacobian;
  return 0.5 * (information + information.transpose());
}

class PlanAddition {
 public:
  PlanAddition(const GraphSnapshot& snapshot, const PlanInGraph& plan, const Pose2& T_world_plan, JointGraph& joint)
      : snapshot_(snapshot), ties_(*plan.ties), joint_(joint) {
    part_.plan = &plan;
    part_.T_world_plan = T_world_plan;
  }

  PlanPart Run() {
    for (const Eigen::Vector2d& corner : ties_.corners) {
      part_.corners.push_back(AddNode({corner.x(), corner.y(), 0.0}));
    }
    std::vector<char> is_seen(ties_.struts.size(), 0);
    for (const WallSighting& sighting : ties_.sightings) {
      if (NodeOf(sighting.map) != PlanPart::kNone) is_seen[static_cast<std::size_t>(sighting.strut)] = 1;
    }
    middles_.assign(ties_.struts.size(), PlanPart::kNone);
    for (std::size_t i = 0; i < ties_.struts.size(); ++i) AddStrut(i, is_seen[i] != 0);
    for (const WallSighting& sighting : ties_.sightings) AddSighting(sighting);
    return std::move(part_);
  }

 private:
  std::size_t AddNode(const Pose2& T_plan_node) {
    return graph::AddNode(snapshot_, part_.T_world_plan * T_plan_node, joint_);
  }
  void AddEdge(std::size_t from, std::size_t to, const Pose2& T_from_to, const Eigen::Matrix3d& information) {
    graph::AddEdge(from, to, T_from_to, information, joint_);
  }

  // One that somebody has seen is a variable at its middle, between its corners; another only joins its corners.
  void AddStrut(std::size_t index, bool is_seen) {
    const PlanStrut& strut = ties_.struts[index];
    const Eigen::Vector2d from = ties_.corners[static_cast<std::size_t>(strut.from)];
    const Eigen::Vector2d way = ties_.corners[static_cast<std::size_t>(strut.to)] - from;
    const std::size_t begin = part_.corners[static_cast<std::size_t>(strut.from)];
    const std::size_t end = part_.corners[static_cast<std::size_t>(strut.to)];
    const double length = way.norm();
    const double direction = std::atan2(way.y(), way.x());
    const Eigen::Vector3d variances = StrutVariances(ties_, length);
    part_.strut_edges.push_back(joint_.graph.edges.size());
    if (!is_seen) return AddEdge(begin, end, {way.x(), way.y(), 0.0}, StrutInformation(variances, direction));
    part_.strut_edges.push_back(joint_.graph.edges.size() + 1);
    const Eigen::Vector2d middle = from + 0.5 * way;
    const std::size_t node = AddNode({middle.x(), middle.y(), direction});
    middles_[index] = node;
    part_.seen_struts.push_back(index);
    AddEdge(begin, node, {0.5 * way.x(), 0.5 * way.y(), direction}, StrutInformation(0.5 * variances, 0.0));
    AddEdge(node, end, {0.5 * length, 0.0, -direction}, StrutInformation(0.5 * variances, direction));
  }

  void AddSighting(const WallSighting& sighting) {
    const std::size_t map = NodeOf(sighting.map);
    part_.edges.push_back(map == PlanPart::kNone ? PlanPart::kNone : joint_.graph.edges.size());
    if (map == PlanPart::kNone) return;
    AddEdge(map, middles_[static_cast<std::size_t>(sighting.strut)],
            sighting.T_map_line * Pose2{-sighting.along, 0.0, 0.0}, SightingInformation(sighting));
  }

  // kNone: it is not part of the graph.
  std::size_t NodeOf(const MapId& map) const {
    const int slot = snapshot_.MapSlot(map);
    const auto node = joint_.node_of.find(slot);
    return slot < 0 || node == joint_.node_of.end() ? PlanPart::kNone : node->second;
  }

  const GraphSnapshot& snapshot_;
  const PlanTies& ties_;
  JointGraph& joint_;
  PlanPart part_;
  std::vector<std::size_t> middles_;  // nodes of struts; kNone: nobody has seen it
};

// How far corners are from where the plan was placed, in the world.
class CornerMoves {
 public:
  CornerMoves(const JointGraph& joint, const PlanPart& part) : part_(part), neighbours_(part.corners.size()) {
    for (std::size_t i = 0; i < part.corners.size(); ++i) {
      const Eigen::Vector2d now = joint.graph.nodes[part.corners[i]].T_world_node.translation();
      moves_.emplace_back(now - Placed(static_cast<int>(i)));
    }
    for (const PlanStrut& strut : part.ties().struts) {
      neighbours_[static_cast<std::size_t>(strut.from)].push_back(strut.to);
      neighbours_[static_cast<std::size_t>(strut.to)].push_back(strut.from);
    }
  }

  bool IsStretchedTooMuch(const PlanStrut& strut) const {
    const Eigen::Vector2d way = Placed(strut.to) - Placed(strut.from);
    if (way.norm() < kShortStrut) return false;
    const double stretch = (way + Move(strut.to) - Move(strut.from)).norm() / way.norm();
    return stretch < kLeastStretch || stretch > kMostStretch;
  }

  // The end that has moved otherwise than the corners around both.
  int OddEnd(const PlanStrut& strut) const {
    std::vector<double> x;
    std::vector<double> y;
    for (const int end : {strut.from, strut.to}) {
      for (const int next : neighbours_[static_cast<std::size_t>(end)]) {
        if (next == strut.from || next == strut.to) continue;
        x.push_back(Move(next).x());
        y.push_back(Move(next).y());
      }
    }
    if (x.empty()) return strut.to;
    const Eigen::Vector2d usual(Median(x), Median(y));
    return (Move(strut.from) - usual).norm() > (Move(strut.to) - usual).norm() ? strut.from : strut.to;
  }

 private:
  Eigen::Vector2d Placed(int corner) const {
    return part_.T_world_plan * part_.ties().corners[static_cast<std::size_t>(corner)];
  }
  const Eigen::Vector2d& Move(int corner) const { return moves_[static_cast<std::size_t>(corner)]; }

  const PlanPart& part_;
  std::vector<Eigen::Vector2d> moves_;
  std::vector<std::vector<int>> neighbours_;  // of each corner
};

}  // namespace

PlanPart AddPlan(const GraphSnapshot& snapshot, const PlanInGraph& plan, const Pose2& T_world_plan, JointGraph& joint) {
  return PlanAddition(snapshot, plan, T_world_plan, joint).Run();
}

Eigen::Matrix2d CornerInformation(const PlanTies& ties, const Eigen::Vector2d& way) {
  const Eigen::Matrix2d to_plan = Eigen::Rotation2Dd(std::atan2(way.y(), way.x())).toRotationMatrix();
  return to_plan * CornerVariances(ties, way.norm()).cwiseInverse().asDiagonal() * to_plan.transpose();
}

std::size_t AddNode(const GraphSnapshot& snapshot, const Pose2& T_world_node, JointGraph& joint) {
  const auto node = joint.graph.nodes.size();
  const auto first = static_cast<std::int64_t>(snapshot.map_slots() + snapshot.link_point_slots());
  const std::int64_t id = first + static_cast<std::int64_t>(node);
  joint.graph.nodes.push_back({.id = id, .T_world_node = T_world_node});
  joint.node_of[id] = node;
  return node;
}

void AddEdge(std::size_t from, std::size_t to, const Pose2& T_from_to, const Eigen::Matrix3d& information,
             JointGraph& joint) {
  joint.graph.edges.push_back({.from = joint.graph.nodes[from].id,
                               .to = joint.graph.nodes[to].id,
                               .T_from_to = T_from_to,
                               .information = information,
                               .robust = true,
                               .enabled = true});
}

std::vector<char> JoinedNodes(const JointGraph& joint) {
  const std::vector<optimize::PoseGraphNode>& nodes = joint.graph.nodes;
  std::vector<std::vector<std::size_t>> neighbours(nodes.size());
  for (const optimize::PoseGraphEdge& edge : joint.graph.edges) {
    if (!edge.enabled) continue;
    const std::size_t from = joint.node_of.at(edge.from);
    const std::size_t to = joint.node_of.at(edge.to);
    neighbours[from].push_back(to);
    neighbours[to].push_back(from);
  }
  std::vector<char> joined(nodes.size(), 0);
  std::vector<std::size_t> reached = {0};
  joined[0] = 1;
  for (std::size_t i = 0; i < reached.size(); ++i) {
    for (const std::size_t next : neighbours[reached[i]]) {
      if (std::exchange(joined[next], 1) == 0) reached.push_back(next);
    }
  }
  return joined;
}

std::set<std::size_t> EdgesAroundStretched(const JointGraph& joint, const PlanPart& part) {
  const auto strut_of = [&](std::size_t sighting) -> const PlanStrut& {
    return part.ties().struts[static_cast<std::size_t>(part.ties().sightings[sighting].strut)];
  };
  const auto is_used = [&](std::size_t sighting) {
    return part.edges[sighting] != PlanPart::kNone && joint.graph.edges[part.edges[sighting]].enabled;
  };
  const CornerMoves moves(joint, part);
  std::set<int> odd;
  for (std::size_t i = 0; i < part.edges.size(); ++i) {
    if (is_used(i) && moves.IsStretchedTooMuch(strut_of(i))) odd.insert(moves.OddEnd(strut_of(i)));
  }
  std::set<std::size_t> edges;
  for (std::size_t i = 0; i < part.edges.size(); ++i) {
    const bool ends_there = odd.contains(strut_of(i).from) || odd.contains(strut_of(i).to);
    if (is_used(i) && ends_there) edges.insert(part.edges[i]);
  }
  return edges;
}

std::optional<Eigen::Matrix3d> CovarianceByPlan(const Eigen::Matrix3d& solved) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(solved.topLeftCorner<2, 2>(), Eigen::EigenvaluesOnly);
  if (axes.eigenvalues()(1) > kMostPositionSigma * kMostPositionSigma) return std::nullopt;
  if (solved(2, 2) > kMostYawSigma * kMostYawSigma) return std::nullopt;
  Eigen::Matrix3d covariance = solved;
  covariance.diagonal() += Eigen::Vector3d(kBendingPosition * kBendingPosition, kBendingPosition * kBendingPosition,
                                           kBendingYaw * kBendingYaw);
  return covariance;
}

}  // namespace enfilade::graph
