// SPDX-License-Identifier: Apache-2.0
#include "tests/e2e/campus/trajectory_error.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>

namespace enfilade::testing {
namespace {

constexpr double kDegreesPerRadian = 180.0 / M_PI;
constexpr double kNear = 0.5;   // s: a pose so near stands for the time
constexpr double kGap = 20.0;   // s: poses so far apart are not interpolated
constexpr double kSame = 1e-3;  // s

// The numbers of each line that has at least `count` of them.
std::vector<std::vector<double>> ReadNumbers(const std::filesystem::path& file, std::size_t count) {
  std::vector<std::vector<double>> lines;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream text(line);
    std::vector<double> numbers;
    for (double number; text >> number;) numbers.push_back(number);
    if (numbers.size() >= count) lines.push_back(std::move(numbers));
  }
  if (lines.empty()) throw std::runtime_error(file.string() + ": cannot be read, or has no line of numbers");
  return lines;
}

std::optional<Pose2> PoseAt(const std::vector<TimedPose>& trajectory, double time) {
  const auto after = std::lower_bound(trajectory.begin(), trajectory.end(), time,
                                      [](const TimedPose& pose, double at) { return pose.time < at; });
  const bool has_after = after != trajectory.end();
  const bool has_before = after != trajectory.begin();
  if (has_after && after->time - time < kSame) return after->pose;
  if (!has_before) return has_after && after->time - time <= kNear ? std::optional(after->pose) : std::nullopt;
  const auto before = std::prev(after);
  if (!has_after) return time - before->time <= kNear ? std::optional(before->pose) : std::nullopt;
  if (std::min(time - before->time, after->time - time) > kNear) return std::nullopt;
  if (after->time - before->time > kGap) {
    return time - before->time < after->time - time ? before->pose : after->pose;
  }
  return Interpolate(before->pose, after->pose, (time - before->time) / (after->time - before->time));
}

// The rigid transform that moves `from` onto `to` with the least squares.
Pose2 Fit(const std::vector<std::pair<Pose2, Pose2>>& pairs) {
  Eigen::Vector2d from = Eigen::Vector2d::Zero();
  Eigen::Vector2d to = Eigen::Vector2d::Zero();
  for (const auto& [a, b] : pairs) {
    from += a.translation() / static_cast<double>(pairs.size());
    to += b.translation() / static_cast<double>(pairs.size());
  }
  double along = 0.0;
  double across = 0.0;
  for (const auto& [a, b] : pairs) {
    const Eigen::Vector2d p = a.translation() - from;
    const Eigen::Vector2d q = b.translation() - to;
    along += p.dot(q);
    across += p.x() * q.y() - p.y() * q.x();
  }
  const Pose2 turn{0.0, 0.0, std::atan2(across, along)};
  const Eigen::Vector2d shift = to - turn * from;
  return {shift.x(), shift.y(), turn.yaw};
}

}  // namespace

std::vector<TimedPose> ReadTrajectory(const std::filesystem::path& file) {
  std::vector<TimedPose> trajectory;
  for (const std::vector<double>& line : ReadNumbers(file, 4)) {
    trajectory.push_back({line[0], {line[1], line[2], line[3]}});
  }
  std::stable_sort(trajectory.begin(), trajectory.end(),
                   [](const TimedPose& a, const TimedPose& b) { return a.time < b.time; });
  return trajectory;
}

std::vector<Relation> ReadRelations(const std::filesystem::path& file) {
  std::vector<Relation> relations;
  for (const std::vector<double>& line : ReadNumbers(file, 8)) {
    relations.push_back({line[0], line[1], {line[2], line[3], line[7]}});
  }
  return relations;
}

TrajectoryError ErrorByRelations(const std::vector<TimedPose>& trajectory, const std::vector<Relation>& relations) {
  TrajectoryError error;
  for (const Relation& relation : relations) {
    const std::optional<Pose2> a = PoseAt(trajectory, relation.time1);
    const std::optional<Pose2> b = PoseAt(trajectory, relation.time2);
    if (!a || !b) {
      ++error.skipped;
      continue;
    }
    const Pose2 off = Between(relation.T_1_2, Between(*a, *b));
    error.metres += off.translation().norm();
    error.degrees += std::abs(WrapAngle(off.yaw)) * kDegreesPerRadian;
    ++error.used;
  }
  error.metres /= std::max(error.used, 1);
  error.degrees /= std::max(error.used, 1);
  return error;
}

TrajectoryError ErrorByReference(const std::vector<TimedPose>& trajectory, const std::vector<TimedPose>& reference) {
  TrajectoryError error;
  std::vector<std::pair<Pose2, Pose2>> pairs;
  for (const TimedPose& right : reference) {
    const std::optional<Pose2> pose = PoseAt(trajectory, right.time);
    if (pose) pairs.emplace_back(*pose, right.pose);
    error.skipped += pose ? 0 : 1;
  }
  if (pairs.empty()) return error;
  const Pose2 T_reference_trajectory = Fit(pairs);
  for (const auto& [pose, right] : pairs) {
    const Pose2 off = Between(right, T_reference_trajectory * pose);
    error.metres += off.translation().squaredNorm();
    error.degrees += std::pow(WrapAngle(off.yaw) * kDegreesPerRadian, 2);
  }
  error.used = static_cast<int>(pairs.size());
  error.metres = std::sqrt(error.metres / error.used);
  error.degrees = std::sqrt(error.degrees / error.used);
  return error;
}

}  // namespace enfilade::testing
