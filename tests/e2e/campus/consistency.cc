// SPDX-License-Identifier: Apache-2.0
#include "tests/e2e/campus/consistency.h"

#include <Eigen/Dense>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "tests/e2e/campus/scan_places.h"

namespace enfilade::testing {
namespace {

constexpr double kChiSquared95 = 7.815;  // 3 degrees of freedom
constexpr double kCertain = 1e-10;       // m^2, rad^2
// Fewer poses, or poses on one spot, do not tell where a map truly is.
constexpr std::size_t kLeastPoses = 20;
constexpr double kLeastExtent = 1.0;  // m

struct PosePair {
  Pose2 T_map_robot;
  Pose2 T_campus_robot;
};

// T_campus_map with the least squares over yaws and positions.
std::optional<Pose2> TrueFrame(const std::vector<PosePair>& pairs) {
  if (pairs.size() < kLeastPoses) return std::nullopt;
  Eigen::Vector2d turn = Eigen::Vector2d::Zero();
  for (const PosePair& pair : pairs) {
    const double yaw = pair.T_campus_robot.yaw - pair.T_map_robot.yaw;
    turn += Eigen::Vector2d(std::cos(yaw), std::sin(yaw));
  }
  Pose2 T_campus_map{0.0, 0.0, std::atan2(turn.y(), turn.x())};
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  double extent = 0.0;
  for (const PosePair& pair : pairs) {
    shift += pair.T_campus_robot.translation() - T_campus_map * pair.T_map_robot.translation();
    extent = std::max(extent, (pair.T_campus_robot.translation() - pairs.front().T_campus_robot.translation()).norm());
  }
  if (extent < kLeastExtent) return std::nullopt;
  shift /= static_cast<double>(pairs.size());
  return Pose2{shift.x(), shift.y(), T_campus_map.yaw};
}

std::map<std::string, Pose2> TrueFrames(const std::vector<DriveTruth>& truths, const MappedState& state) {
  std::map<std::string, std::vector<PosePair>> pairs;
  for (const DriveTruth& truth : truths) {
    const auto stretches = state.stretches.find(truth.robot);
    if (stretches == state.stretches.end()) continue;
    for (const client::MappedStretch& stretch : stretches->second) {
      for (const client::MappedPose& pose : stretch.poses) {
        pairs[stretch.map].push_back({pose.T_map_robot, TruthAt(truth, pose.time)});
      }
    }
  }
  std::map<std::string, Pose2> frames;
  for (const auto& [map, of_map] : pairs) {
    if (const std::optional<Pose2> frame = TrueFrame(of_map)) frames.emplace(map, *frame);
  }
  return frames;
}

void Compare(const PoseWithCovariance& estimate, const Pose2& truth, Consistency& consistency) {
  const Pose2& pose = estimate.pose;
  consistency.Add({pose.x - truth.x, pose.y - truth.y, WrapAngle(pose.yaw - truth.yaw)}, estimate.covariance);
}

}  // namespace

void Consistency::Add(const Eigen::Vector3d& error, const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  if (solver.eigenvalues().minCoeff() < kCertain) return;
  const double squared = error.dot(covariance.ldlt().solve(error));
  ++samples;
  inside += squared <= kChiSquared95 ? 1 : 0;
  nees += squared / 3.0;
  squares += error.head<2>().squaredNorm();
}

void Consistency::Add(const Consistency& other) {
  samples += other.samples;
  inside += other.inside;
  nees += other.nees;
  squares += other.squares;
}

double Consistency::rms() const { return samples > 0 ? std::sqrt(squares / samples) : 0.0; }

GraphConsistency MeasureConsistency(const std::vector<DriveTruth>& truths, const MappedState& state) {
  const std::map<std::string, Pose2> frames = TrueFrames(truths, state);
  GraphConsistency result;
  for (const MapTransform& transform : state.transforms) {
    const auto a = frames.find(transform.a);
    const auto b = frames.find(transform.b);
    if (a == frames.end() || b == frames.end()) continue;
    Compare(transform.T_a_b, Between(a->second, b->second), transform.hops == 1 ? result.joins : result.chains);
  }
  const auto root = frames.find(state.root);
  if (root != frames.end()) result.T_campus_world = root->second;
  for (const auto& [map, T_world_map] : state.poses) {
    const auto frame = frames.find(map);
    if (root == frames.end() || frame == frames.end() || map == state.root) continue;
    Compare(T_world_map, Between(root->second, frame->second), result.maps);
  }
  return result;
}

}  // namespace enfilade::testing
