// SPDX-License-Identifier: Apache-2.0
// A robot that drives through a drawn plan and measures its walls.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/prior/localization/plan_localizer.h"
#include "core/prior/plan/plan_graph.h"

namespace enfilade::prior {

struct DrivenPlan {
  PlanGraph plan;
  double metres = 0.05;  // of the building, per unit of the plan

  // Of the building: as the sheet, y upwards.
  Eigen::Vector2d InBuilding(const Eigen::Vector2d& sheet) const { return {metres * sheet.x(), -metres * sheet.y()}; }

  // How far the first wall is, m; `reach` if there is none.
  double Range(const Eigen::Vector2d& from, double angle, double reach) const {
    const Eigen::Vector2d ahead(std::cos(angle), std::sin(angle));
    double nearest = reach;
    for (const PlanWall& wall : plan.walls) {
      const Eigen::Vector2d a = InBuilding(plan.corners[static_cast<std::size_t>(wall.from)].point) - from;
      const Eigen::Vector2d way = InBuilding(plan.corners[static_cast<std::size_t>(wall.to)].point) - from - a;
      const double across = ahead.x() * way.y() - ahead.y() * way.x();
      if (std::abs(across) < 1e-12) continue;
      const double range = (a.x() * way.y() - a.y() * way.x()) / across;
      const double share = (a.x() * ahead.y() - a.y() * ahead.x()) / across;
      if (range > 0 && share >= 0 && share <= 1) nearest = std::min(nearest, range);
    }
    return nearest;
  }

  std::vector<Eigen::Vector2d> HitsAt(const Pose2& pose) const {
    constexpr double kReach = 10.0;
    std::vector<Eigen::Vector2d> hits;
    for (int beam = 0; beam < 180; ++beam) {
      const double angle = beam * 2 * kDegree;
      const double range = Range(pose.translation(), pose.yaw + angle, kReach);
      if (range < kReach) hits.emplace_back(range * std::cos(angle), range * std::sin(angle));
    }
    return hits;
  }
};

struct Driven {
  std::vector<Pose2> truth;     // in the building
  std::vector<PlanLook> looks;  // in the frame of the first pose
};

// From way point to way point (m, sheet's orientation: y down), a look every 0.3 m and every 15 degrees of a turn.
inline Driven DriveAlong(const DrivenPlan& building, const std::vector<Eigen::Vector2d>& way) {
  Driven driven;
  const auto look = [&](const Pose2& pose) {
    driven.truth.push_back(pose);
    driven.looks.push_back({Between(driven.truth.front(), pose), building.HitsAt(pose)});
  };
  for (std::size_t i = 0; i + 1 < way.size(); ++i) {
    const Eigen::Vector2d from(way[i].x(), -way[i].y());
    const Eigen::Vector2d leg = Eigen::Vector2d(way[i + 1].x(), -way[i + 1].y()) - from;
    const double yaw = std::atan2(leg.y(), leg.x());
    if (i > 0) {
      const double before = driven.truth.back().yaw;
      const double turn = WrapAngle(yaw - before);
      const int parts = static_cast<int>(std::ceil(std::abs(turn) / (15 * kDegree)));
      for (int k = 1; k < parts; ++k) look({from.x(), from.y(), WrapAngle(before + k * turn / parts)});
    }
    const int steps = static_cast<int>(std::ceil(leg.norm() / 0.3));
    for (int k = 0; k < steps; ++k) {
      const Eigen::Vector2d at = from + static_cast<double>(k) / steps * leg;
      look({at.x(), at.y(), yaw});
    }
  }
  return driven;
}

}  // namespace enfilade::prior
