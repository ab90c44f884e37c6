// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/initialization/chordal.h"

#include <Eigen/LU>
#include <cmath>

#include "core/optimize/initialization/translations.h"
#include "core/optimize/linear/block_cholesky.h"

namespace enfilade::optimize {
namespace {

// The information of the yaw with the translation marginalised out (Schur complement).
double YawInformation(const Eigen::Matrix3d& information) {
  const Eigen::Vector2d coupling = information.topRightCorner<2, 1>();
  return information(2, 2) - coupling.dot(information.topLeftCorner<2, 2>().inverse() * coupling);
}

// Multiplication by the complex number e^(i yaw).
Eigen::Matrix2d Rotation(double yaw) {
  const double c = std::cos(yaw);
  const double s = std::sin(yaw);
  return (Eigen::Matrix2d() << c, -s, s, c).finished();
}

// The relaxed z of every free node, in elimination order.
std::optional<Eigen::VectorXd> RelaxedRotations(const IndexedGraph& graph, const GraphLayout& layout) {
  BlockMatrix<2> H;
  H.SetZero(layout.structure);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(2 * layout.structure.size);
  for (std::size_t k = 0; k < graph.edges.size(); ++k) {
    const IndexedEdge& edge = graph.edges[k];
    const double kappa = YawInformation(edge.information);
    const Eigen::Matrix2d M = kappa * Rotation(edge.measurement.T_from_to.yaw);
    const int from = layout.position[edge.from];
    const int to = layout.position[edge.to];
    if (to >= 0) H.diagonal[to] += kappa * Eigen::Matrix2d::Identity();
    if (from >= 0) H.diagonal[from] += kappa * Eigen::Matrix2d::Identity();
    if (to >= 0 && from < 0) b.segment<2>(2 * to) += M * Rotation(graph.poses[edge.from].yaw).col(0);
    if (from >= 0 && to < 0) b.segment<2>(2 * from) += M.transpose() * Rotation(graph.poses[edge.to].yaw).col(0);
    if (const int block = layout.block[k]; block >= 0) {
      if (to > from) {
        H.lower[block] -= M;
      } else {
        H.lower[block] -= M.transpose();
      }
    }
  }
  if (!Factorize(layout.structure, H)) return std::nullopt;
  SolveFactorized(layout.structure, H, b);
  return b;
}

}  // namespace

std::optional<std::vector<Pose2>> ChordalPoses(const IndexedGraph& graph, const GraphLayout& layout) {
  const std::optional<Eigen::VectorXd> z = RelaxedRotations(graph, layout);
  if (!z) return std::nullopt;
  std::vector<Pose2> poses = graph.poses;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const int k = 2 * layout.position[i];
    if (k >= 0) poses[i] = {0.0, 0.0, std::atan2((*z)[k + 1], (*z)[k])};
  }
  if (!SolveTranslations(graph, layout, {}, poses, poses)) return std::nullopt;
  return poses;
}

}  // namespace enfilade::optimize
