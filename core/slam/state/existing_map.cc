// SPDX-License-Identifier: Apache-2.0
#include "core/slam/state/existing_map.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/geometry/pose_codec.h"
#include "core/slam/matching/motion_model.h"

namespace enfilade::slam {
namespace {

constexpr double kSigmas = 3.0;

}  // namespace

SubmapContent ContentOf(const grid::OccupancyGrid& grid, const SlamOptions& options) {
  if (grid.cells.empty()) return {{}, {}, {}, SubmapGrid(options.resolution, options.occupancy)};
  return {{}, {}, {}, SubmapGrid::FromOccupancy(grid, options.occupancy)};
}

PoseWithCovariance PoseAtScan(const ExistingMapEntry& entry, const std::optional<Pose2>& T_odom_now,
                              const SlamOptions& options) {
  const double sigma = options.graph.match_sigma_floor;
  const double yaw_sigma = options.graph.match_yaw_floor;
  PoseWithCovariance pose = entry.T_map_robot;
  pose.covariance = 0.5 * (pose.covariance + pose.covariance.transpose().eval());
  pose.covariance.diagonal() += Eigen::Vector3d(sigma * sigma, sigma * sigma, yaw_sigma * yaw_sigma);
  if (!entry.T_odom_robot || !T_odom_now) return pose;
  MotionOptions since_entry = options.motion;  // the floors are for windows in which scans are searched for
  since_entry.translation_floor = 0.0;
  since_entry.yaw_floor = 0.0;
  const PredictedMotion motion = PredictMotion(entry.T_odom_robot, T_odom_now, {}, 0.0, since_entry);
  const double t = motion.sigma_translation * motion.sigma_translation;
  const Eigen::Vector3d variances(t, t, motion.sigma_yaw * motion.sigma_yaw);
  return Compose(pose, {motion.T_last_now, variances.asDiagonal()});
}

FinishedSubmap TiedToFirst(const FinishedSubmap& existing, const PoseWithCovariance& T_map_first,
                           const SlamOptions& options) {
  SubmapContent content = DecodeSubmapContent(existing.content, options.occupancy).value();  // written by this program
  const Eigen::Matrix3d information = T_map_first.covariance.inverse();
  content.next = NextSubmap{T_map_first.pose, 0.5 * (information + information.transpose())};
  return FinishExistingMap(existing.version + 1, content);
}

EntryReach ReachOf(const ExistingMapEntry& entry) {
  const Eigen::Matrix3d& covariance = entry.T_map_robot.covariance;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(covariance.topLeftCorner<2, 2>());
  return {kSigmas * std::sqrt(std::max(solver.eigenvalues()[1], 0.0)),
          kSigmas * std::sqrt(std::max(covariance(2, 2), 0.0))};
}

void PutEntry(BinaryWriter& writer, const std::optional<ExistingMapEntry>& entry) {
  writer.Put<std::uint8_t>(entry.has_value());
  if (!entry) return;
  PutPose(writer, entry->T_map_robot.pose);
  PutMatrix(writer, entry->T_map_robot.covariance);
  writer.Put<std::uint8_t>(entry->T_odom_robot.has_value());
  PutPose(writer, entry->T_odom_robot.value_or(Pose2{}));
}

std::optional<ExistingMapEntry> GetEntry(BinaryReader& reader) {
  if (reader.Get<std::uint8_t>() == 0) return std::nullopt;
  ExistingMapEntry entry;
  entry.T_map_robot.pose = GetPose(reader);
  entry.T_map_robot.covariance = GetMatrix(reader);
  const bool has_odometry = reader.Get<std::uint8_t>() != 0;
  const Pose2 T_odom_robot = GetPose(reader);
  if (has_odometry) entry.T_odom_robot = T_odom_robot;
  return entry;
}

}  // namespace enfilade::slam
