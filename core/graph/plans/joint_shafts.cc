// SPDX-License-Identifier: Apache-2.0
#include "core/graph/plans/joint_shafts.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "core/graph/plans/shafts.h"
#include "fmt/format.h"

namespace enfilade::graph {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

// A plan's corner says nothing of the turn of a shaft that it holds, but matrices must have an inverse.
constexpr double kNoTurnSigma = 1.0;  // rad

using Points = std::vector<Vector2d>;

// How a point of a node at `lever` (m, in the node's frame) moves with the node's pose.
Eigen::Matrix<double, 2, 3> JacobianAt(const Vector2d& lever) {
  Eigen::Matrix<double, 2, 3> jacobian;
  jacobian << 1.0, 0.0, -lever.y(), 0.0, 1.0, lever.x();
  return jacobian;
}

Matrix3d Symmetric(const Matrix3d& matrix) { return 0.5 * (matrix + matrix.transpose()); }

class ShaftAddition {
 public:
  ShaftAddition(const GraphSnapshot& snapshot, const std::vector<PlanPart>& parts, JointGraph& joint)
      : snapshot_(snapshot), parts_(parts), joint_(joint) {}

  JointShafts Run() {
    struct Pair {
      Key a, b;
    };
    std::vector<Pair> pairs;
    std::map<Key, int> partners;
    for (std::size_t a = 0; a < parts_.size(); ++a) {
      for (std::size_t b = 0; b < parts_.size(); ++b) {
        if (parts_[a].plan->level >= parts_[b].plan->level) continue;
        for (const SameShaft& same : SameShafts(parts_[a].ties(), parts_[b].ties())) {
          pairs.push_back({{a, same.a}, {b, same.b}});
          ++partners[pairs.back().a];
          ++partners[pairs.back().b];
        }
      }
    }
    for (const Pair& pair : pairs) {
      Tie(NodeOf(pair.a), NodeOf(pair.b), 2.0 / (1 + std::max(partners.at(pair.a), partners.at(pair.b))));
    }
    return std::move(shafts_);
  }

 private:
  using Key = std::pair<std::size_t, std::size_t>;  // part, shaft

  std::size_t NodeOf(const Key& key) {
    const auto [known, is_new] = node_of_.try_emplace(key, shafts_.nodes.size());
    if (is_new) AddShaft(key.first, key.second);
    return known->second;
  }

  const ShaftInPlan& ShaftOf(const ShaftNode& node) const { return parts_[node.part].ties().shafts[node.shaft]; }

  // All its corners are drawn together: four are worth no more than one.
  void AddShaft(std::size_t part_index, std::size_t shaft_index) {
    const PlanPart& part = parts_[part_index];
    ShaftNode added{.part = part_index, .shaft = shaft_index};
    const ShaftInPlan& shaft = ShaftOf(added);
    const Vector2d middle = shaft.middle();
    added.node = AddNode(snapshot_, part.T_world_plan * Pose2{middle.x(), middle.y(), 0.0}, joint_);
    const auto corners = static_cast<double>(shaft.outline.size());
    for (std::size_t i = 0; i < shaft.outline.size(); ++i) {
      const auto holder = static_cast<std::size_t>(shaft.held_by[i]);
      const Vector2d from_holder = middle - part.ties().corners[holder];
      const Eigen::Matrix2d measured = CornerInformation(part.ties(), shaft.outline[i] - part.ties().corners[holder]);
      const auto jacobian = JacobianAt(shaft.outline[i] - middle);
      Matrix3d information = jacobian.transpose() * measured * jacobian / corners;
      information(2, 2) += 1.0 / (kNoTurnSigma * kNoTurnSigma);
      added.edges.push_back(joint_.graph.edges.size());
      AddEdge(part.corners[holder], added.node, {from_holder.x(), from_holder.y(), 0.0}, Symmetric(information),
              joint_);
      joint_.graph.edges.back().robust = false;
    }
    shafts_.nodes.push_back(std::move(added));
  }

  void Tie(std::size_t index_a, std::size_t index_b, double weight) {
    const ShaftNode& a = shafts_.nodes[index_a];
    const ShaftNode& b = shafts_.nodes[index_b];
    const Pose2 T_plan_plan = Between(parts_[a.part].T_world_plan, parts_[b.part].T_world_plan);
    const Points outline = ShaftOf(a).outline;
    Points other = ShaftOf(b).outline;
    for (Vector2d& corner : other) corner = T_plan_plan * corner;
    other = InOrderOf(outline, std::move(other));
    for (Vector2d& corner : other) corner = Inverse(T_plan_plan) * corner;
    // The frames of the nodes lie at the middles, and are turned as their plans are.
    const Vector2d middle_a = ShaftOf(a).middle();
    const Vector2d middle_b = ShaftOf(b).middle();
    Points in_a, in_b;
    Matrix3d information = Matrix3d::Zero();
    for (std::size_t i = 0; i < outline.size(); ++i) {
      in_a.emplace_back(outline[i] - middle_a);
      in_b.emplace_back(other[i] - middle_b);
      const auto jacobian = JacobianAt(in_b.back());
      information += jacobian.transpose() * jacobian;
    }
    information *= weight / (kShaftSigma * kShaftSigma * static_cast<double>(outline.size()));
    shafts_.ties.push_back({index_a, index_b, ShaftOf(a).name, joint_.graph.edges.size()});
    AddEdge(a.node, b.node, FitRigid(in_a, in_b), Symmetric(information), joint_);
  }

  const GraphSnapshot& snapshot_;
  const std::vector<PlanPart>& parts_;
  JointGraph& joint_;
  JointShafts shafts_;
  std::map<Key, std::size_t> node_of_;
};

}  // namespace

JointShafts AddShafts(const GraphSnapshot& snapshot, const std::vector<PlanPart>& parts, JointGraph& joint) {
  return ShaftAddition(snapshot, parts, joint).Run();
}

std::vector<ShaftUse> UsesOf(const JointGraph& joint, const JointShafts& shafts, const std::vector<PlanPart>& parts,
                             const std::vector<double>& edge_chi2, std::size_t index) {
  std::vector<ShaftUse> uses;
  const auto pose = [&](const ShaftNode& shaft) { return joint.graph.nodes[shaft.node].T_world_node; };
  for (const ShaftTie& tie : shafts.ties) {
    const ShaftNode& a = shafts.nodes[tie.a];
    const ShaftNode& b = shafts.nodes[tie.b];
    if (a.part != index && b.part != index) continue;
    const optimize::PoseGraphEdge& edge = joint.graph.edges[tie.edge];
    uses.push_back({.name = tie.name,
                    .other = parts[a.part == index ? b.part : a.part].plan->id,
                    .used = edge.enabled,
                    .distance = ((pose(a) * edge.T_from_to).translation() - pose(b).translation()).norm(),
                    .chi2 = edge_chi2[tie.edge]});
  }
  return uses;
}

std::string ContradictionOfShafts(const std::vector<ShaftUse>& shafts) {
  std::set<PriorMapId> agree, disagree;
  for (const ShaftUse& shaft : shafts) (shaft.used ? agree : disagree).insert(shaft.other);
  std::erase_if(disagree, [&](const PriorMapId& other) { return agree.contains(other); });
  if (disagree.size() < 2 || disagree.size() <= agree.size()) return "";
  return fmt::format("its shafts lie elsewhere than those of {} plans of other levels", disagree.size());
}

}  // namespace enfilade::graph
