// SPDX-License-Identifier: Apache-2.0
#include "tests/support/manhattan_graph.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <random>
#include <utility>

namespace enfilade::testing {
namespace {

Eigen::Matrix3d MeasurementCovariance(const ManhattanOptions& options) {
  Eigen::Matrix3d correlation;
  correlation << 1.0, 0.3, -0.2, 0.3, 1.0, 0.4, -0.2, 0.4, 1.0;
  const Eigen::Vector3d sigma(options.sigma_xy, 0.7 * options.sigma_xy, options.sigma_yaw);
  return sigma.asDiagonal() * correlation * sigma.asDiagonal();
}

class Drive {
 public:
  explicit Drive(const ManhattanOptions& options) : options_(options), random_(options.seed) {}

  ManhattanGraph Record() {
    DriveStreets();
    for (int i = 1; i < options_.nodes; ++i) AddEdge(i - 1, i, false, false);
    for (int i = 0; i < options_.nodes; ++i) CloseLoops(i);
    return std::move(result_);
  }

 private:
  void DriveStreets() {
    Pose2 pose;
    std::uniform_int_distribution<int> choice(0, 5);
    while (static_cast<int>(result_.truth.size()) < options_.nodes) {
      result_.truth.push_back(pose);
      const int turn = choice(random_);
      if (turn < 2) pose.yaw = WrapAngle(pose.yaw + (turn == 0 ? M_PI_2 : -M_PI_2));
      while (!IsInside(pose * Pose2{1.0, 0.0, 0.0})) pose.yaw = WrapAngle(pose.yaw + M_PI_2);
      pose = pose * Pose2{1.0, 0.0, 0.0};
    }
  }

  bool IsInside(const Pose2& pose) const {
    const double half = 0.5 * options_.streets;
    return std::abs(pose.x) <= half && std::abs(pose.y) <= half;
  }

  void CloseLoops(int i) {
    std::vector<int> near;
    for (int j = 0; j < i - 10; ++j) {
      if ((result_.truth[i].translation() - result_.truth[j].translation()).norm() < 1.5) near.push_back(j);
    }
    if (near.empty()) return;
    for (double wanted = options_.loops_per_node; wanted > 0.0; wanted -= 1.0) {
      if (uniform_(random_) > wanted) continue;
      if (uniform_(random_) < options_.outlier_share) {
        AddEdge(static_cast<int>(uniform_(random_) * (i - 1)), i, true, true);
      } else {
        AddEdge(near[static_cast<std::size_t>(uniform_(random_) * static_cast<double>(near.size()))], i, true, false);
      }
    }
  }

  void AddEdge(int from, int to, bool is_loop, bool is_outlier) {
    optimize::PoseGraphEdge edge;
    edge.from = from;
    edge.to = to;
    edge.robust = is_loop;
    edge.information = covariance_.inverse();
    if (is_outlier) {
      edge.T_from_to = {4.0 * uniform_(random_) - 2.0, 4.0 * uniform_(random_) - 2.0, 6.0 * uniform_(random_) - 3.0};
    } else {
      edge.T_from_to = Measured(Between(result_.truth[from], result_.truth[to]));
    }
    if (!is_loop) {
      if (from == 0) result_.graph.nodes.push_back({0, result_.truth[0]});
      result_.graph.nodes.push_back({to, result_.graph.nodes.back().T_world_node * edge.T_from_to});
    }
    result_.graph.edges.push_back(edge);
    result_.is_outlier.push_back(is_outlier);
  }

  // Such that the error of the true pose has the covariance.
  Pose2 Measured(const Pose2& T_from_to) {
    const Eigen::Vector3d e = factor_ * Eigen::Vector3d(normal_(random_), normal_(random_), normal_(random_));
    const double yaw = WrapAngle(T_from_to.yaw - e.z());
    const double c = std::cos(yaw);
    const double s = std::sin(yaw);
    return {T_from_to.x - (c * e.x() - s * e.y()), T_from_to.y - (s * e.x() + c * e.y()), yaw};
  }

  const ManhattanOptions options_;
  std::mt19937 random_;
  std::uniform_real_distribution<double> uniform_;
  std::normal_distribution<double> normal_;
  const Eigen::Matrix3d covariance_ = MeasurementCovariance(options_);
  const Eigen::Matrix3d factor_ = covariance_.llt().matrixL();
  ManhattanGraph result_;
};

}  // namespace

ManhattanGraph MakeManhattanGraph(const ManhattanOptions& options) { return Drive(options).Record(); }

double RootMeanSquareError(const optimize::PoseGraph& graph, const std::vector<Pose2>& truth) {
  double sum = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    sum += (graph.nodes[i].T_world_node.translation() - truth[i].translation()).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(truth.size()));
}

}  // namespace enfilade::testing
