// SPDX-License-Identifier: Apache-2.0
#include "core/closure/session_track.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace enfilade::closure {
namespace {

constexpr TimeNs kMaxOdometryGap = kNsPerSecond / 2;
constexpr TimeNs kMaxTrajectoryGap = 10 * kNsPerSecond;
constexpr TimeNs kMaxBareGap = kNsPerSecond;  // without odometry
// Standard deviations of what a robot may have done unseen.
constexpr double kBlindSpeed = 0.5;    // m/s
constexpr double kBlindTurn = 0.3;     // rad/s
constexpr double kMaxBlindWay = 10.0;  // m

double SecondsIn(DurationNs duration) { return std::abs(ToSeconds(duration)); }

template <typename Stamped>
auto FirstAtOrAfter(const std::vector<Stamped>& samples, TimeNs time) {
  return std::lower_bound(samples.begin(), samples.end(), time,
                          [](const Stamped& sample, TimeNs t) { return sample.time < t; });
}

// The nearest in time; the earlier of two.
template <typename Stamped>
const Stamped* FindNearest(const std::vector<Stamped>& samples, TimeNs time) {
  if (samples.empty()) return nullptr;
  const auto after = FirstAtOrAfter(samples, time);
  if (after == samples.begin()) return &samples.front();
  if (after == samples.end()) return &samples.back();
  const auto before = std::prev(after);
  return time - before->time <= after->time - time ? &*before : &*after;
}

}  // namespace

SessionTrack::SessionTrack(std::vector<slam::StampedPose> trajectory, std::vector<sensor::Odometry> odometry,
                           const DoorClosureOptions& options)
    : trajectory_(std::move(trajectory)),
      odometry_(std::move(odometry)),
      sigma_(options.odometry_sigma),
      yaw_sigma_(options.odometry_yaw_sigma),
      match_variances_(options.match_sigma * options.match_sigma, options.match_sigma * options.match_sigma,
                       options.match_yaw_sigma * options.match_yaw_sigma) {
  const auto by_time = [](const auto& a, const auto& b) { return a.time < b.time; };
  std::stable_sort(trajectory_.begin(), trajectory_.end(), by_time);
  std::stable_sort(odometry_.begin(), odometry_.end(), by_time);
}

std::optional<Pose2> SessionTrack::OdometryAt(TimeNs time) const {
  const auto after = FirstAtOrAfter(odometry_, time);
  if (after != odometry_.end() && after != odometry_.begin()) {
    const auto before = std::prev(after);
    if (after->time - before->time <= 2 * kMaxOdometryGap) {
      const double t = static_cast<double>(time - before->time) / static_cast<double>(after->time - before->time);
      return Interpolate(before->T_odom_robot, after->T_odom_robot, t);
    }
  }
  const sensor::Odometry* nearest = FindNearest(odometry_, time);
  if (nearest == nullptr || std::abs(nearest->time - time) > kMaxOdometryGap) return std::nullopt;
  return nearest->T_odom_robot;
}

std::optional<PoseWithCovariance> SessionTrack::PoseAt(TimeNs time) const {
  const slam::StampedPose* nearest = FindNearest(trajectory_, time);
  if (nearest == nullptr || std::abs(nearest->time - time) > kMaxTrajectoryGap) return std::nullopt;
  const std::optional<Pose2> then = OdometryAt(nearest->time);
  const std::optional<Pose2> now = OdometryAt(time);
  if (!then || !now) {
    if (std::abs(nearest->time - time) > kMaxBareGap) return std::nullopt;
    return PoseWithCovariance{nearest->T_map_robot, Eigen::Matrix3d::Zero()};
  }
  const Pose2 way = Between(*then, *now);
  const double length = way.translation().norm() + std::abs(way.yaw) * 0.5;
  PoseWithCovariance step{way, Eigen::Matrix3d::Zero()};
  const double variance = sigma_ * sigma_ * length * length;
  step.covariance.diagonal() << variance, variance, yaw_sigma_ * yaw_sigma_ * length * length;
  return Compose({nearest->T_map_robot, Eigen::Matrix3d::Zero()}, step);
}

PoseWithCovariance SessionTrack::GuessPoseAt(TimeNs time, const slam::StampedPose& start) const {
  const slam::StampedPose* mapped = FindNearest(trajectory_, time);
  const slam::StampedPose& from = mapped != nullptr ? *mapped : start;
  const sensor::Odometry* then = FindNearest(odometry_, from.time);
  const sensor::Odometry* now = FindNearest(odometry_, time);
  PoseWithCovariance step;
  double blind = SecondsIn(time - from.time);
  if (then != nullptr && now != nullptr) {
    step.pose = Between(then->T_odom_robot, now->T_odom_robot);
    blind = SecondsIn(then->time - from.time) + SecondsIn(now->time - time);
  }
  const double length = step.pose.translation().norm() + std::abs(step.pose.yaw) * 0.5;
  const double sigma = sigma_ * length + std::min(kMaxBlindWay, kBlindSpeed * blind);
  const double yaw_sigma = yaw_sigma_ * length + std::min(M_PI, kBlindTurn * blind);
  step.covariance.diagonal() << sigma * sigma, sigma * sigma, yaw_sigma * yaw_sigma;
  step.covariance.diagonal() += match_variances_;
  return Compose({from.T_map_robot, Eigen::Matrix3d::Zero()}, step);
}

std::optional<PoseWithCovariance> SessionTrack::ToMap(const Pose2& T_odom_x, TimeNs time) const {
  std::optional<PoseWithCovariance> T_map_robot = PoseAt(time);
  if (!T_map_robot) return std::nullopt;
  const std::optional<Pose2> T_odom_robot = OdometryAt(time);
  if (!T_odom_robot) return T_map_robot;
  return Compose(*T_map_robot, {Between(*T_odom_robot, T_odom_x), Eigen::Matrix3d::Zero()});
}

std::optional<PoseWithCovariance> SessionTrack::RelativePose(const Pose2& T_odom_x, TimeNs seen, TimeNs time) const {
  std::optional<PoseWithCovariance> T_map_x = ToMap(T_odom_x, seen);
  std::optional<PoseWithCovariance> T_map_robot = PoseAt(time);
  if (!T_map_x || !T_map_robot) return std::nullopt;
  T_map_x->covariance.diagonal() += match_variances_;
  T_map_robot->covariance.diagonal() += match_variances_;
  return Compose(Inverse(*T_map_x), *T_map_robot);
}

}  // namespace enfilade::closure
