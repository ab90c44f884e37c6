// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/ceres/ceres_minimize.h"

#include <array>
#include <vector>

#include "ceres/loss_function.h"
#include "ceres/problem.h"
#include "ceres/solver.h"
#include "core/optimize/ceres/ceres_edge_cost.h"
#include "core/optimize/linear/normal_equations.h"

namespace enfilade::optimize {
namespace {

class KernelLoss : public ceres::LossFunction {
 public:
  explicit KernelLoss(const RobustKernel& kernel) : kernel_(kernel) {}
  void Evaluate(double squared_error, double rho[3]) const override {
    const RobustCost robust = enfilade::optimize::Evaluate(kernel_, squared_error);
    rho[0] = robust.cost;
    rho[1] = robust.weight;
    rho[2] = robust.curvature;
  }

 private:
  RobustKernel kernel_;
};

}  // namespace

Minimum MinimizeWithCeres(const MinimizeOptions& options, const GraphLayout&, IndexedGraph& graph) {
  std::vector<std::array<double, 3>> poses;
  for (const Pose2& pose : graph.poses) poses.push_back({pose.x, pose.y, pose.yaw});
  KernelLoss loss(options.kernel);
  ceres::Problem::Options problem_options;
  problem_options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(problem_options);
  for (std::array<double, 3>& pose : poses) problem.AddParameterBlock(pose.data(), 3);
  for (const IndexedEdge& edge : graph.edges) {
    const bool robust = edge.robust && options.kernel.type != RobustKernel::Type::kNone;
    problem.AddResidualBlock(NewEdgeCost(edge.measurement, edge.information), robust ? &loss : nullptr,
                             poses[edge.from].data(), poses[edge.to].data());
  }
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (graph.held[i]) problem.SetParameterBlockConstant(poses[i].data());
  }
  ceres::Solver::Options solver_options;
  solver_options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  solver_options.max_num_iterations = options.max_iterations;
  solver_options.function_tolerance = options.relative_tolerance;
  solver_options.gradient_tolerance = 0.0;
  solver_options.parameter_tolerance = 0.0;
  solver_options.num_threads = 1;
  solver_options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver_options, &problem, &summary);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!graph.held[i]) graph.poses[i] = {poses[i][0], poses[i][1], WrapAngle(poses[i][2])};
  }
  Minimum minimum;
  minimum.cost = GraphCost(graph, graph.poses, options.kernel);
  minimum.iterations = static_cast<int>(summary.iterations.size()) - 1;
  minimum.converged = summary.termination_type == ceres::CONVERGENCE;
  return minimum;
}

}  // namespace enfilade::optimize
