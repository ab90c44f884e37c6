// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "core/geometry/pose2.h"
#include "core/graph/graph_snapshot.h"
#include "core/graph/plans/plan_ties.h"
#include "core/graph/solved_graph.h"
#include "tests/unit/core/graph/scene.h"

namespace enfilade::testing {

// Rooms in a row, each with a map of its own in the room's middle, somehow turned: "m0" is the root. Room i has the
// walls i (its left one) and i + 1, and one below and one above.
class RowOfRooms {
 public:
  static constexpr double kWidth = 6.0;  // m, of a room
  static constexpr double kDepth = 5.0;
  static constexpr double kAcross = 0.03;  // m, of what is seen
  static constexpr double kYaw = 0.005;    // rad

  RowOfRooms(int rooms, double corner_sigma, unsigned seed) : rooms_(rooms), random_(seed) {
    for (int i = 0; i < rooms; ++i) {
      world_.T_world_maps.push_back({(i + 0.5) * kWidth, 0.5 * kDepth, WrapAngle(0.7 * i)});
    }
    const Pose2 root = world_.T_world_maps[0];
    for (Pose2& T_world_map : world_.T_world_maps) T_world_map = Between(root, T_world_map);
    for (int i = 0; i <= rooms; ++i) {
      for (const double y : {0.0, kDepth}) truth_.push_back(Inverse(root) * Eigen::Vector2d(i * kWidth, y));
    }
    for (int i = 0; i <= rooms; ++i) ties_.struts.push_back({2 * i, 2 * i + 1, static_cast<int>(ties_.struts.size())});
    for (int i = 0; i < rooms; ++i) {
      for (const int side : {0, 1}) {
        ties_.struts.push_back({2 * i + side, 2 * i + 2 + side, static_cast<int>(ties_.struts.size())});
      }
    }
    for (const Eigen::Vector2d& corner : truth_) {
      ties_.corners.emplace_back(corner + Eigen::Vector2d(Noise(corner_sigma), Noise(corner_sigma)));
    }
    ties_.corner_sigma = std::max(0.02, corner_sigma);
    bends_.assign(static_cast<std::size_t>(rooms), Eigen::Vector2d::Zero());
    for (int i = 0; i < rooms; ++i) {
      ties_.maps.push_back({Map(i), world_.T_world_maps[static_cast<std::size_t>(i)]});
    }
  }

  graph::PlanTies& ties() { return ties_; }
  const World& world() const { return world_; }
  int Below(int room) const { return rooms_ + 1 + 2 * room; }
  static MapId Map(int room) { return M(Numbered("m", room)); }

  // Of each room, all walls are off together, m.
  void Bend(double sigma) {
    for (Eigen::Vector2d& bend : bends_) bend = {Noise(sigma), Noise(sigma)};
  }
  void SeeAll(int room) {
    for (const int strut : {room, room + 1, Below(room), Below(room) + 1}) See(room, strut);
  }
  void See(int room, int strut) {
    const graph::PlanStrut& ends = ties_.struts[static_cast<std::size_t>(strut)];
    const Eigen::Vector2d from = truth_[static_cast<std::size_t>(ends.from)];
    const Eigen::Vector2d way = truth_[static_cast<std::size_t>(ends.to)] - from;
    const Eigen::Vector2d middle = from + 0.5 * way;
    const Eigen::Vector2d& bend = bends_[static_cast<std::size_t>(room)];
    const Pose2 T_world_line{middle.x() + bend.x(), middle.y() + bend.y(), std::atan2(way.y(), way.x())};
    const Pose2 noise{Noise(0.1), Noise(kAcross), Noise(kYaw)};
    ties_.sightings.push_back(
        {.strut = strut,
         .map = Map(room),
         .T_map_line = Between(world_.T_world_maps[static_cast<std::size_t>(room)], T_world_line) * noise,
         .along = 0.0,
         .length = way.norm(),
         .across_sigma = kAcross,
         .yaw_sigma = kYaw});
  }
  // A door between a room and the next.
  graph::LinkPoint Door(int room, double position, double yaw) {
    const Eigen::Matrix3d covariance =
        Eigen::Vector3d(position * position, position * position, yaw * yaw).asDiagonal();
    const Pose2 place = Interpolate(world_.T_world_maps[static_cast<std::size_t>(room)],
                                    world_.T_world_maps[static_cast<std::size_t>(room + 1)], 0.5);
    return world_.See(Numbered("d", room), place, {room, room + 1}, {covariance, covariance}, random_);
  }
  graph::GraphSnapshot WithPlan(const std::vector<graph::LinkPoint>& doors) const {
    const graph::GraphSnapshot maps = WithoutPlan(doors);
    return Apply(maps, {.version = maps.version() + 1,
                        .plans = std::vector<graph::PlanInGraph>{{PriorMapId("p"), "digest",
                                                                  std::make_shared<const graph::PlanTies>(ties_)}}})
        .value();
  }
  graph::GraphSnapshot WithoutPlan(const std::vector<graph::LinkPoint>& doors) const {
    return testing::Graph(world_.MapIds(), doors);
  }
  // m.
  double ErrorOf(const graph::SolvedGraph& solution, int room) const {
    const auto pose = solution.map_poses.find(Map(room));
    if (pose == solution.map_poses.end()) return 1e9;
    const Pose2& truth = world_.T_world_maps[static_cast<std::size_t>(room)];
    return (pose->second.pose.translation() - truth.translation()).norm();
  }
  // Squared, in standard deviations.
  double SurpriseOf(const graph::SolvedGraph& solution, int room) const {
    const PoseWithCovariance& pose = solution.map_poses.at(Map(room));
    const Pose2& truth = world_.T_world_maps[static_cast<std::size_t>(room)];
    const Eigen::Vector3d error(pose.pose.x - truth.x, pose.pose.y - truth.y, WrapAngle(pose.pose.yaw - truth.yaw));
    return error.dot(pose.covariance.inverse() * error);
  }

 private:
  double Noise(double sigma) { return std::normal_distribution<double>(0.0, sigma + 1e-12)(random_); }

  int rooms_;
  std::mt19937_64 random_;
  World world_;
  std::vector<Eigen::Vector2d> truth_;  // corners, in the world
  std::vector<Eigen::Vector2d> bends_;
  graph::PlanTies ties_;
};

}  // namespace enfilade::testing
