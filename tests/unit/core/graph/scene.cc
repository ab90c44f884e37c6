// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/core/graph/scene.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace enfilade::testing {

MapId M(const std::string& id) { return MapId(id); }
LinkPointId L(const std::string& id) { return LinkPointId(id); }
graph::MapInGraph MapNamed(const std::string& id, int level) {
  return {.id = M(id), .display_name = id, .level = level};
}

graph::Anchor AnchorIn(const std::string& map, const Pose2& T_map_place, const Eigen::Matrix3d& covariance) {
  return {.map = M(map), .T_map_place = T_map_place, .covariance = covariance};
}

graph::LinkPoint Joining(const std::string& id, std::vector<graph::Anchor> anchors) {
  return {.id = L(id), .anchors = std::move(anchors)};
}

graph::GraphSnapshot Graph(const std::vector<std::string>& maps, const std::vector<graph::LinkPoint>& link_points,
                           const graph::GraphSnapshot& snapshot) {
  graph::SnapshotChanges changes{.version = snapshot.version() + 1};
  for (const std::string& map : maps) changes.maps.push_back(MapNamed(map));
  changes.link_points = link_points;
  auto graph = graph::Apply(snapshot, changes);
  if (!graph.ok()) throw std::invalid_argument(graph.status().ToString());
  return *std::move(graph);
}

double Uniform(double low, double high, std::mt19937_64& random) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

Pose2 Draw(const PoseWithCovariance& pose, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const Eigen::Matrix3d L_factor = pose.covariance.llt().matrixL();
  const Eigen::Vector3d z(normal(random), normal(random), normal(random));
  const Eigen::Vector3d d = L_factor * z;
  return {pose.pose.x + d.x(), pose.pose.y + d.y(), WrapAngle(pose.pose.yaw + d.z())};
}

Eigen::Matrix3d RandomCovariance(double position, double yaw, std::mt19937_64& random) {
  Eigen::Matrix3d factor = Eigen::Vector3d(position * Uniform(0.5, 1.2, random), position * Uniform(0.5, 1.2, random),
                                           yaw * Uniform(0.5, 1.2, random))
                               .asDiagonal();
  factor(1, 0) = 0.4 * position * Uniform(-1.0, 1.0, random);
  factor(2, 0) = 0.4 * yaw * Uniform(-1.0, 1.0, random);
  factor(2, 1) = 0.4 * yaw * Uniform(-1.0, 1.0, random);
  return factor * factor.transpose();
}

graph::LinkPoint World::See(const std::string& id, const Pose2& T_world_place, const std::vector<int>& maps,
                            const std::vector<Eigen::Matrix3d>& covariances, std::mt19937_64& random) const {
  std::vector<graph::Anchor> anchors;
  for (std::size_t i = 0; i < maps.size(); ++i) {
    const Pose2 truth = Between(T_world_maps[static_cast<std::size_t>(maps[i])], T_world_place);
    anchors.push_back(AnchorIn(Numbered("m", maps[i]), Draw({truth, covariances[i]}, random), covariances[i]));
  }
  return Joining(id, std::move(anchors));
}

std::vector<std::string> World::MapIds() const {
  std::vector<std::string> ids;
  for (std::size_t i = 0; i < T_world_maps.size(); ++i) ids.push_back(Numbered("m", i));
  return ids;
}

World RandomWorld(int maps, double size_m, std::mt19937_64& random) {
  World world{{Pose2()}};
  while (static_cast<int>(world.T_world_maps.size()) < maps) {
    world.T_world_maps.push_back(
        {Uniform(0.0, size_m, random), Uniform(0.0, size_m, random), Uniform(-M_PI, M_PI, random)});
  }
  return world;
}

}  // namespace enfilade::testing
