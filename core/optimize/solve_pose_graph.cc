#include "core/optimize/solve_pose_graph.h"

#include <Eigen/SparseCholesky>
#include <unordered_map>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/optimize/edge_error.h"
#include "core/optimize/indexed_graph.h"

namespace enfilade {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

double SquaredError(const IndexedEdge& edge, const std::vector<Pose2>& poses) {
  const Eigen::Vector3d e = EdgeError(poses[edge.from], poses[edge.to], edge.T_from_to);
  return e.dot(edge.information * e);
}

double Cost(const IndexedGraph& graph, const std::vector<Pose2>& poses, const RobustKernel& kernel) {
  double sum = 0.0;
  for (const IndexedEdge& edge : graph.edges) {
    const double s = SquaredError(edge, poses);
    sum += edge.robust ? Evaluate(kernel, s).cost : s;
  }
  return sum;
}

std::vector<int> NumberUnknowns(const IndexedGraph& graph) {
  std::vector<int> column(graph.poses.size(), -1);
  int next = 0;
  for (std::size_t i = 0; i < column.size(); ++i) {
    if (!graph.held[i]) column[i] = 3 * next++;
  }
  return column;
}

void Linearize(const IndexedGraph& graph, const std::vector<int>& column, const RobustKernel& kernel, Sparse& H,
               Eigen::VectorXd& b) {
  std::vector<Eigen::Triplet<double>> triplets;
  triplets.reserve(graph.edges.size() * 36);
  b.setZero();
  const auto add = [&](int row, int col, const Eigen::Matrix3d& block) {
    if (row < 0 || col < 0) return;
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) triplets.emplace_back(row + r, col + c, block(r, c));
    }
  };
  for (const IndexedEdge& edge : graph.edges) {
    const LinearizedEdge l = LinearizeEdge(graph.poses[edge.from], graph.poses[edge.to], edge.T_from_to);
    const double weight = edge.robust ? Evaluate(kernel, l.error.dot(edge.information * l.error)).weight : 1.0;
    const Eigen::Matrix3d W = weight * edge.information;
    const int i = column[edge.from];
    const int j = column[edge.to];
    add(i, i, l.J_from.transpose() * W * l.J_from);
    add(j, j, l.J_to.transpose() * W * l.J_to);
    add(i, j, l.J_from.transpose() * W * l.J_to);
    add(j, i, l.J_to.transpose() * W * l.J_from);
    if (i >= 0) b.segment<3>(i) -= l.J_from.transpose() * (W * l.error);
    if (j >= 0) b.segment<3>(j) -= l.J_to.transpose() * (W * l.error);
  }
  H.setFromTriplets(triplets.begin(), triplets.end());
}

// Levenberg-Marquardt.
void Minimize(const SolveOptions& options, IndexedGraph& graph, SolveReport& report) {
  const std::vector<int> column = NumberUnknowns(graph);
  const int size = *std::max_element(column.begin(), column.end()) + 3;
  if (size <= 2) return;
  Sparse H(size, size);
  Eigen::VectorXd b(size);
  Eigen::SimplicialLDLT<Sparse> solver;
  double cost = Cost(graph, graph.poses, options.kernel);
  double lambda = 0.0;
  Linearize(graph, column, options.kernel, H, b);
  solver.analyzePattern(H);
  bool converged = false;
  for (int iteration = 0; iteration < options.max_iterations && !converged; ++iteration) {
    ++report.iterations;
    Sparse damped = H;
    damped.diagonal() *= 1.0 + lambda;
    solver.factorize(damped);
    std::vector<Pose2> poses = graph.poses;
    double largest = 0.0;
    if (solver.info() == Eigen::Success) {
      const Eigen::VectorXd step = solver.solve(b);
      largest = step.cwiseAbs().maxCoeff();
      for (std::size_t i = 0; i < poses.size(); ++i) {
        if (column[i] < 0) continue;
        poses[i].x += step[column[i]];
        poses[i].y += step[column[i] + 1];
        poses[i].yaw = WrapAngle(poses[i].yaw + step[column[i] + 2]);
      }
    }
    const double next = Cost(graph, poses, options.kernel);
    if (solver.info() == Eigen::Success && next <= cost) {
      converged = cost - next <= options.relative_tolerance * cost || largest <= options.step_tolerance;
      graph.poses = std::move(poses);
      cost = next;
      lambda = lambda < 1e-8 ? 0.0 : lambda * 0.1;
      Linearize(graph, column, options.kernel, H, b);
    } else {
      converged = largest <= options.step_tolerance && solver.info() == Eigen::Success;
      lambda = lambda == 0.0 ? 1e-6 : lambda * 10.0;
      if (lambda > 1e12) break;
    }
  }
  report.converged = report.converged && converged;
}

absl::Status AddCovariances(const SolveOptions& options, const PoseGraph& graph,
                            const std::vector<IndexedGraph>& components, SolveReport& report) {
  std::unordered_map<std::int64_t, std::size_t> wanted;
  for (const std::int64_t id : options.covariance_of) {
    wanted.emplace(id, report.covariances.size());
    report.covariances.push_back({id, Eigen::Matrix3d::Zero()});
  }
  if (wanted.empty()) return absl::OkStatus();
  for (const IndexedGraph& part : components) {
    const std::vector<int> column = NumberUnknowns(part);
    const int size = *std::max_element(column.begin(), column.end()) + 3;
    if (size <= 2) continue;
    Sparse H(size, size);
    Eigen::VectorXd b(size);
    Linearize(part, column, options.kernel, H, b);
    Eigen::SimplicialLDLT<Sparse> solver(H);
    for (std::size_t i = 0; i < part.poses.size(); ++i) {
      const auto found = wanted.find(graph.nodes[part.sources[i]].id);
      if (found == wanted.end() || column[i] < 0) continue;
      Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(size, 3);
      unit.block<3, 3>(column[i], 0).setIdentity();
      report.covariances[found->second].covariance = solver.solve(unit).block<3, 3>(column[i], 0);
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<SolveReport> SolvePoseGraph(const SolveOptions& options, PoseGraph& graph) {
  ENFILADE_ASSIGN_OR_RETURN(std::vector<IndexedGraph> components, IndexComponents(graph, options.fixed));
  SolveReport report;
  report.converged = true;
  report.components = static_cast<int>(components.size());
  report.edge_chi2.assign(graph.edges.size(), 0.0);
  report.edge_weight.assign(graph.edges.size(), 0.0);
  for (IndexedGraph& part : components) {
    report.initial_chi2 += Cost(part, part.poses, {});
    report.initial_cost += Cost(part, part.poses, options.kernel);
    Minimize(options, part, report);
    report.final_chi2 += Cost(part, part.poses, {});
    report.final_cost += Cost(part, part.poses, options.kernel);
    for (const IndexedEdge& edge : part.edges) {
      const double s = SquaredError(edge, part.poses);
      report.edge_weight[edge.source] = edge.robust ? Evaluate(options.kernel, s).weight : 1.0;
    }
  }
  ENFILADE_RETURN_IF_ERROR(AddCovariances(options, graph, components, report));
  std::unordered_map<std::int64_t, Pose2> solved;
  for (const IndexedGraph& part : components) {
    for (std::size_t i = 0; i < part.poses.size(); ++i) {
      graph.nodes[part.sources[i]].T_world_node = part.poses[i];
      solved[graph.nodes[part.sources[i]].id] = part.poses[i];
    }
  }
  for (std::size_t k = 0; k < graph.edges.size(); ++k) {
    const PoseGraphEdge& edge = graph.edges[k];
    const Eigen::Vector3d e = EdgeError(solved.at(edge.from), solved.at(edge.to), edge.T_from_to);
    report.edge_chi2[k] = e.dot(edge.information * e);
  }
  return report;
}

}  // namespace enfilade
