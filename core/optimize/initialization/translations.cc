// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/initialization/translations.h"

#include "core/optimize/linear/block_cholesky.h"

namespace enfilade::optimize {
namespace {

double WeightAt(const std::vector<Pose2>& poses, const IndexedEdge& edge, const RobustKernel& kernel) {
  if (!edge.robust || kernel.type == RobustKernel::Type::kNone) return 1.0;
  const Eigen::Vector3d e = EdgeError(poses[edge.from], poses[edge.to], edge.measurement);
  return Evaluate(kernel, e.dot(edge.information * e)).weight;
}

}  // namespace

bool SolveTranslations(const IndexedGraph& graph, const GraphLayout& layout, const RobustKernel& kernel,
                       const std::vector<Pose2>& weighted_at, std::vector<Pose2>& poses) {
  BlockMatrix<2> H;
  H.SetZero(layout.structure);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(2 * layout.structure.size);
  for (std::size_t k = 0; k < graph.edges.size(); ++k) {
    const IndexedEdge& edge = graph.edges[k];
    const LinearizedEdge l = LinearizeEdge(poses[edge.from], poses[edge.to], edge.measurement);
    const double weight = WeightAt(weighted_at, edge, kernel);
    const Eigen::Matrix2d R_T = l.J_to.topLeftCorner<2, 2>();
    const Eigen::Matrix2d A = weight * (R_T.transpose() * edge.information.topLeftCorner<2, 2>() * R_T);
    const Eigen::Vector2d g = weight * (R_T.transpose() * edge.information.topRows<2>() * l.error);
    const int from = layout.position[edge.from];
    const int to = layout.position[edge.to];
    if (to >= 0) {
      H.diagonal[to] += A;
      b.segment<2>(2 * to) -= g;
    }
    if (from >= 0) {
      H.diagonal[from] += A;
      b.segment<2>(2 * from) += g;
    }
    if (const int block = layout.block[k]; block >= 0) H.lower[block] -= A;  // A is symmetric
  }
  if (!Factorize(layout.structure, H)) return false;
  SolveFactorized(layout.structure, H, b);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const int k = 2 * layout.position[i];
    if (k < 0) continue;
    poses[i].x += b[k];
    poses[i].y += b[k + 1];
  }
  return true;
}

}  // namespace enfilade::optimize
