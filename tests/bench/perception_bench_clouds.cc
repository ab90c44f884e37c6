// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <fstream>
#include <numbers>

#include "perception/cloud/decode_cloud.h"
#include "perception/cloud/registration.h"
#include "tests/bench/perception_bench.h"

namespace enfilade::bench {
namespace {

using perception::Cloud;
using perception::Registration;

Eigen::Isometry3d PoseOf(double x, double y, double yaw) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T.translation() = Eigen::Vector3d(x, y, 0.0);
  return T;
}

nlohmann::json Measure(const Cloud& source, const Cloud& target, const Eigen::Isometry3d& guess,
                       const Eigen::Isometry3d* truth = nullptr) {
  Registration found;
  const nlohmann::json time = Time(3, [&] { found = perception::RegisterClouds(source, target, guess).value(); });
  nlohmann::json document = {{"accepted", found.accepted},
                             {"inlier_share", found.inlier_share},
                             {"fitness", found.fitness},
                             {"turned", found.turned},
                             {"time", time}};
  if (truth != nullptr) {
    const Eigen::Isometry3d error = truth->inverse() * found.T_target_source;
    document["error_m"] = error.translation().norm();
    document["error_deg"] = Eigen::AngleAxisd(error.linear()).angle() * 180.0 / std::numbers::pi;
  }
  return document;
}

}  // namespace

nlohmann::json MeasureClouds(const std::filesystem::path& data) {
  const std::filesystem::path lidar = data / "clouds/small_gicp";
  const std::filesystem::path room = data / "clouds/pcl";
  if (!std::filesystem::exists(lidar) || !std::filesystem::exists(room)) return nullptr;
  const Cloud source = perception::DecodeCloud(ReadAll(lidar / "source.ply")).value();
  const Cloud target = perception::DecodeCloud(ReadAll(lidar / "target.ply")).value();
  const Cloud first = perception::DecodeCloud(ReadAll(room / "room_scan1.pcd")).value();
  const Cloud second = perception::DecodeCloud(ReadAll(room / "room_scan2.pcd")).value();
  Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
  std::ifstream matrix(lidar / "T_target_source.txt");
  for (int k = 0; k < 16; ++k) matrix >> truth.matrix()(k / 4, k % 4);
  const Eigen::Isometry3d guess = PoseOf(1.79387, 0.720047, 0.6931);  // as published with the scans
  return {{"lidar pair, from the identity", Measure(source, target, PoseOf(0, 0, 0), &truth)},
          {"lidar pair, turned by 180 deg", Measure(source, target, PoseOf(0, 0, std::numbers::pi), &truth)},
          {"lidar pair, off by 1.2 m and 30 deg", Measure(source, target, PoseOf(1.0, -0.7, 0.52), &truth)},
          {"room, published guess", Measure(second, first, guess)},
          {"room, turned by 180 deg", Measure(second, first, guess * PoseOf(0, 0, std::numbers::pi))},
          {"wrong pair: room in lidar", Measure(second, target, PoseOf(0, 0, 0))},
          {"wrong pair: lidar in room", Measure(source, first, PoseOf(0, 0, 0))}};
}

}  // namespace enfilade::bench
