// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/linear/normal_equations.h"

namespace enfilade::optimize {

double GraphCost(const IndexedGraph& graph, const std::vector<Pose2>& poses, const RobustKernel& kernel) {
  double sum = 0.0;
  for (const IndexedEdge& edge : graph.edges) {
    const Eigen::Vector3d e = EdgeError(poses[edge.from], poses[edge.to], edge.measurement);
    const double squared_error = e.dot(edge.information * e);
    sum += edge.robust ? Evaluate(kernel, squared_error).cost : squared_error;
  }
  return sum;
}

void Linearize(const IndexedGraph& graph, const GraphLayout& layout, const RobustKernel& kernel,
               NormalEquations& equations) {
  equations.H.SetZero(layout.structure);
  equations.b.setZero(3 * layout.structure.size);
  for (std::size_t k = 0; k < graph.edges.size(); ++k) {
    const IndexedEdge& edge = graph.edges[k];
    const LinearizedEdge l = LinearizeEdge(graph.poses[edge.from], graph.poses[edge.to], edge.measurement);
    const Eigen::Vector3d weighted_error = edge.information * l.error;
    const double weight = edge.robust ? Evaluate(kernel, l.error.dot(weighted_error)).weight : 1.0;
    // With J_from = -J_to K, all blocks follow from A = J_to^T Omega J_to.
    const Eigen::Matrix3d A = weight * (l.J_to.transpose() * edge.information * l.J_to);
    const Eigen::Vector3d g = weight * (l.J_to.transpose() * weighted_error);
    const Eigen::Matrix3d AK = A * l.K;
    const int from = layout.position[edge.from];
    const int to = layout.position[edge.to];
    if (to >= 0) {
      equations.H.diagonal[to] += A;
      equations.b.segment<3>(3 * to) -= g;
    }
    if (from >= 0) {
      equations.H.diagonal[from] += l.K.transpose() * AK;
      equations.b.segment<3>(3 * from) += l.K.transpose() * g;
    }
    if (const int block = layout.block[k]; block >= 0) {
      if (to > from) {
        equations.H.lower[block] -= AK;
      } else {
        equations.H.lower[block] -= AK.transpose();
      }
    }
  }
}

double PredictedDecrease(const BlockStructure& structure, const NormalEquations& equations, const Eigen::VectorXd& dx) {
  const BlockMatrix<3>& H = equations.H;
  double quadratic = 0.0;
  for (int j = 0; j < structure.size; ++j) {
    const Eigen::Vector3d x_j = dx.segment<3>(3 * j);
    Eigen::Vector3d off = Eigen::Vector3d::Zero();
    for (int p = structure.column_begin[j]; p < structure.column_begin[j + 1]; ++p) {
      off += H.lower[p].transpose() * dx.segment<3>(3 * structure.row[p]);
    }
    quadratic += x_j.dot(H.diagonal[j] * x_j + 2.0 * off);
  }
  return 2.0 * equations.b.dot(dx) - quadratic;
}

std::vector<Pose2> Moved(const GraphLayout& layout, const std::vector<Pose2>& poses, const Eigen::VectorXd& dx) {
  std::vector<Pose2> moved = poses;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const int k = 3 * layout.position[i];
    if (k < 0) continue;
    moved[i] = {poses[i].x + dx[k], poses[i].y + dx[k + 1], WrapAngle(poses[i].yaw + dx[k + 2])};
  }
  return moved;
}

}  // namespace enfilade::optimize
