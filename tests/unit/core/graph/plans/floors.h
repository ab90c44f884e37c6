// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "core/geometry/pose2.h"
#include "core/graph/graph_snapshot.h"
#include "core/graph/plans/plan_ties.h"
#include "core/graph/solved_graph.h"
#include "tests/unit/core/graph/scene.h"

namespace enfilade::testing {

// Floors above each other, each a row of rooms with a map of its own in each, and a plan "p0", "p1", ... of which each
// room has seen its four walls. Map "m0", of the first room of floor 0, is the root. Two lifts, "A" and "B", go through
// all floors, in the first room and in the last. Each plan is drawn in a frame of its own.
class Floors {
 public:
  static constexpr double kWidth = 6.0;  // m, of a room
  static constexpr double kDepth = 5.0;
  static constexpr double kAcross = 0.03;  // m, of what is seen
  static constexpr double kYaw = 0.005;    // rad

  // `drawn`: m, how far each corner of the plans is off. `plumb`: ... the lifts, from floor to floor.
  Floors(int floors, int rooms, double drawn, double plumb, unsigned seed)
      : rooms_(rooms), drawn_(drawn), random_(seed), ties_(static_cast<std::size_t>(floors)) {
    for (int floor = 0; floor < floors; ++floor) {
      for (int room = 0; room < rooms; ++room) {
        const Pose2 there{(room + 0.5) * kWidth, 0.5 * kDepth, WrapAngle(0.7 * room - 1.3 * floor)};
        world_.T_world_maps.push_back(there);
      }
    }
    T_world_building_ = Inverse(world_.T_world_maps[0]);
    for (Pose2& T_world_map : world_.T_world_maps) T_world_map = T_world_building_ * T_world_map;
    for (int floor = 0; floor < floors; ++floor) Draw(floor, plumb);
  }

  graph::PlanTies& ties(int floor) { return ties_[static_cast<std::size_t>(floor)]; }
  static PriorMapId Plan(int floor) { return PriorMapId(Numbered("p", floor)); }
  MapId Map(int floor, int room) const { return M(Numbered("m", floor * rooms_ + room)); }

  // A passage between a room of one floor and the same of the next.
  graph::LinkPoint Stairs(int floor, int room, double position, double yaw) {
    return Link(floor, room, floor + 1, room, position, yaw);
  }
  // A door between a room and the next.
  graph::LinkPoint Door(int floor, int room, double position, double yaw) {
    return Link(floor, room, floor, room + 1, position, yaw);
  }

  // `floors`: of the plans in use.
  graph::GraphSnapshot Graph(const std::vector<int>& floors,
                             const std::vector<graph::LinkPoint>& link_points = {}) const {
    const graph::GraphSnapshot maps = testing::Graph(world_.MapIds(), link_points);
    std::vector<graph::PlanInGraph> plans;
    for (const int floor : floors) {
      plans.push_back({Plan(floor), "digest",
                       std::make_shared<const graph::PlanTies>(ties_[static_cast<std::size_t>(floor)]), floor});
    }
    return Apply(maps, {.version = maps.version() + 1, .plans = std::move(plans)}).value();
  }

  // m; nothing if the room has no pose.
  std::optional<double> ErrorOf(const graph::SolvedGraph& solution, int floor, int room) const {
    const auto pose = solution.map_poses.find(Map(floor, room));
    if (pose == solution.map_poses.end()) return std::nullopt;
    return (pose->second.pose.translation() - Truth(floor, room).translation()).norm();
  }
  // Squared, in standard deviations.
  double SurpriseOf(const graph::SolvedGraph& solution, int floor, int room) const {
    const PoseWithCovariance& pose = solution.map_poses.at(Map(floor, room));
    const Pose2 truth = Truth(floor, room);
    const Eigen::Vector3d error(pose.pose.x - truth.x, pose.pose.y - truth.y, WrapAngle(pose.pose.yaw - truth.yaw));
    return error.dot(pose.covariance.inverse() * error);
  }

 private:
  const Pose2& Truth(int floor, int room) const {
    return world_.T_world_maps[static_cast<std::size_t>(floor * rooms_ + room)];
  }
  double Noise(double sigma) { return std::normal_distribution<double>(0.0, sigma + 1e-12)(random_); }

  graph::LinkPoint Link(int floor, int room, int to_floor, int to_room, double position, double yaw) {
    const Eigen::Matrix3d covariance =
        Eigen::Vector3d(position * position, position * position, yaw * yaw).asDiagonal();
    const int a = floor * rooms_ + room, b = to_floor * rooms_ + to_room;
    return world_.See(fmt::format("l{}-{}", a, b), Interpolate(Truth(floor, room), Truth(to_floor, to_room), 0.5),
                      {a, b}, {covariance, covariance}, random_);
  }

  void Draw(int floor, double plumb) {
    graph::PlanTies& ties = ties_[static_cast<std::size_t>(floor)];
    const Pose2 T_world_plan = floor == 0 ? Pose2() : Pose2{30.0 * floor, -20.0, 1.9 * floor};
    const Pose2 T_plan_building = Inverse(T_world_plan) * T_world_building_;
    const auto drawn = [&](const Eigen::Vector2d& point) -> Eigen::Vector2d {
      return T_plan_building * point + Eigen::Vector2d(Noise(drawn_), Noise(drawn_));
    };
    std::vector<Eigen::Vector2d> built;
    for (int i = 0; i <= rooms_; ++i) {
      for (const double y : {0.0, kDepth}) built.emplace_back(i * kWidth, y);
    }
    for (const Eigen::Vector2d& corner : built) ties.corners.push_back(drawn(corner));
    for (int i = 0; i <= rooms_; ++i) AddWall(ties, 2 * i, 2 * i + 1);
    for (int i = 0; i < rooms_; ++i) {
      for (const int side : {0, 1}) AddWall(ties, 2 * i + side, 2 * i + 2 + side);
    }
    ties.corner_sigma = std::max(0.02, drawn_);
    for (int room = 0; room < rooms_; ++room) {
      ties.maps.push_back({Map(floor, room), Inverse(T_world_plan) * Truth(floor, room)});
      for (const int strut : {room, room + 1, rooms_ + 1 + 2 * room, rooms_ + 2 + 2 * room}) {
        See(ties, floor, room, strut, built);
      }
    }
    std::sort(ties.maps.begin(), ties.maps.end(), [](const auto& a, const auto& b) { return a.map < b.map; });
    const int last = 2 * rooms_;
    AddLift(ties, "A", {0.2, 0.2}, {0, 0, 1, 1}, plumb, drawn);
    AddLift(ties, "B", {rooms_ * kWidth - 2.2, kDepth - 2.2}, {last + 1, last + 1, last, last + 1}, plumb, drawn);
  }

  static void AddWall(graph::PlanTies& ties, int from, int to) {
    ties.struts.push_back({from, to, static_cast<int>(ties.struts.size())});
  }

  void See(graph::PlanTies& ties, int floor, int room, int strut, const std::vector<Eigen::Vector2d>& built) {
    const graph::PlanStrut& ends = ties.struts[static_cast<std::size_t>(strut)];
    const Eigen::Vector2d from = T_world_building_ * built[static_cast<std::size_t>(ends.from)];
    const Eigen::Vector2d way = T_world_building_ * built[static_cast<std::size_t>(ends.to)] - from;
    const Eigen::Vector2d middle = from + 0.5 * way;
    const Pose2 T_world_line{middle.x(), middle.y(), std::atan2(way.y(), way.x())};
    ties.sightings.push_back(
        {.strut = strut,
         .map = Map(floor, room),
         .T_map_line = Between(Truth(floor, room), T_world_line) * Pose2{Noise(0.1), Noise(kAcross), Noise(kYaw)},
         .along = 0.0,
         .length = way.norm(),
         .across_sigma = kAcross,
         .yaw_sigma = kYaw});
  }

  // 2 m x 1.6 m.
  template <typename Drawn>
  void AddLift(graph::PlanTies& ties, const std::string& name, const Eigen::Vector2d& at, std::vector<int> held_by,
               double plumb, const Drawn& drawn) {
    const Eigen::Vector2d off = at + Eigen::Vector2d(Noise(plumb), Noise(plumb));
    graph::ShaftInPlan lift{.name = name, .is_lift = true, .outline = {}, .held_by = std::move(held_by)};
    for (const Eigen::Vector2d& corner : {Eigen::Vector2d(0, 0), {2.0, 0}, {2.0, 1.6}, {0, 1.6}}) {
      lift.outline.push_back(drawn(off + corner));
    }
    ties.shafts.push_back(std::move(lift));
  }

  int rooms_;
  double drawn_;
  std::mt19937_64 random_;
  World world_;
  Pose2 T_world_building_;
  std::vector<graph::PlanTies> ties_;
};

}  // namespace enfilade::testing
