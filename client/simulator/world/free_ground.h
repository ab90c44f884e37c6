// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "client/simulator/world/world.h"

namespace enfilade::simulator {

// Where a robot may drive on one level, in a grid of 0.1 m, and ways through it: to plan routes around furniture.
// People are not obstacles, nor are the doors of lifts.
class FreeGround {
 public:
  struct Box {
    Eigen::Vector2d lower;
    Eigen::Vector2d upper;
  };

  // Ground is free if nothing that stops a robot is nearer than `clearance` m.
  explicit FreeGround(const LevelWorld& level, double clearance = 0.25);

  bool IsFree(const Eigen::Vector2d& point) const { return DistanceAt(point) >= clearance_; }
  bool IsFree(const Eigen::Vector2d& a, const Eigen::Vector2d& b) const { return LineDistance(a, b) >= clearance_; }

  // The corners of a short way from `from` (not among them) to `to`, in the middle of narrow places. Empty: there is
  // none within the box (default: on the level). Both ends may be 0.3 m off free ground.
  std::vector<Eigen::Vector2d> Way(const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                                   const std::optional<Box>& box = std::nullopt) const;

 private:
  static constexpr double kCell = 0.1;      // m
  static constexpr double kFarthest = 0.6;  // m: distances beyond it do not matter

  double DistanceAt(const Eigen::Vector2d& point) const;
  double LineDistance(const Eigen::Vector2d& a, const Eigen::Vector2d& b) const;
  int CellOf(const Eigen::Vector2d& point) const;  // -1: outside
  Eigen::Vector2d MiddleOf(int cell) const;
  int NearestFree(const Eigen::Vector2d& point) const;  // -1: none
  std::vector<int> Search(int from, int to, const Box& box) const;
  std::vector<Eigen::Vector2d> Straighten(const std::vector<Eigen::Vector2d>& points) const;

  double clearance_;
  Eigen::Vector2d lower_;
  int width_ = 0;
  int height_ = 0;
  std::vector<float> distance_;  // m, to the nearest obstacle, at most kFarthest
};

}  // namespace enfilade::simulator
