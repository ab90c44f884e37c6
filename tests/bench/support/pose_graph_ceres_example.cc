// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/support/pose_graph_ceres_example.h"

#include <Eigen/Cholesky>
#include <array>
#include <cmath>
#include <unordered_map>

#include "ceres/ceres.h"

namespace enfilade::bench {
namespace {

template <typename T>
T NormalizedAngle(const T& angle) {
  const T two_pi(2.0 * M_PI);
  return angle - two_pi * ceres::floor((angle + T(M_PI)) / two_pi);
}

struct AngleOnCircle {
  template <typename T>
  bool Plus(const T* angle, const T* delta, T* sum) const {
    *sum = NormalizedAngle(*angle + *delta);
    return true;
  }
  template <typename T>
  bool Minus(const T* a, const T* b, T* difference) const {
    *difference = NormalizedAngle(*a - *b);
    return true;
  }
};

class RelativePoseError {
 public:
  RelativePoseError(const Pose2& measured, const Eigen::Matrix3d& weight) : measured_(measured), weight_(weight) {}

  template <typename T>
  bool operator()(const T* x_a, const T* y_a, const T* yaw_a, const T* x_b, const T* y_b, const T* yaw_b,
                  T* residuals) const {
    const Eigen::Rotation2D<T> R_a(*yaw_a);
    const Eigen::Matrix<T, 2, 1> between(*x_b - *x_a, *y_b - *y_a);
    const Eigen::Matrix<T, 2, 1> predicted = R_a.toRotationMatrix().transpose() * between;
    const Eigen::Matrix2d R_measured = Eigen::Rotation2Dd(measured_.yaw).toRotationMatrix();
    Eigen::Matrix<T, 3, 1> error;
    error.template head<2>() = R_measured.transpose().cast<T>() * (predicted - measured_.translation().cast<T>());
    error(2) = NormalizedAngle(*yaw_b - *yaw_a - T(measured_.yaw));
    Eigen::Map<Eigen::Matrix<T, 3, 1>> weighted(residuals);
    weighted = weight_.cast<T>() * error;
    return true;
  }

 private:
  const Pose2 measured_;
  const Eigen::Matrix3d weight_;
};

}  // namespace

CeresExampleResult SolveAsCeresExample(optimize::PoseGraph& graph) {
  std::unordered_map<std::int64_t, Pose2*> poses;
  for (optimize::PoseGraphNode& node : graph.nodes) poses[node.id] = &node.T_world_node;
  ceres::Problem problem;
  ceres::Manifold* angle = new ceres::AutoDiffManifold<AngleOnCircle, 1, 1>;
  for (const optimize::PoseGraphEdge& edge : graph.edges) {
    Pose2& from = *poses.at(edge.from);
    Pose2& to = *poses.at(edge.to);
    const Eigen::Matrix3d L = edge.information.llt().matrixL();
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<RelativePoseError, 3, 1, 1, 1, 1, 1, 1>(
                                 new RelativePoseError(edge.T_from_to, L.transpose())),
                             nullptr, &from.x, &from.y, &from.yaw, &to.x, &to.y, &to.yaw);
    problem.SetManifold(&from.yaw, angle);
    problem.SetManifold(&to.yaw, angle);
  }
  Pose2& first = graph.nodes.front().T_world_node;
  problem.SetParameterBlockConstant(&first.x);
  problem.SetParameterBlockConstant(&first.y);
  problem.SetParameterBlockConstant(&first.yaw);
  ceres::Solver::Options options;
  options.max_num_iterations = 100;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return {2.0 * summary.final_cost, static_cast<int>(summary.iterations.size()) - 1};
}

}  // namespace enfilade::bench
