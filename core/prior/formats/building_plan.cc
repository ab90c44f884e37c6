// SPDX-License-Identifier: Apache-2.0
#include "core/prior/formats/building_plan.h"

#include <cmath>

namespace enfilade::prior {
namespace {

using Eigen::Vector2d;

// Metres with y up become units of the drawing with y down.
Vector2d ToSheet(const BuildingLevel& level, const Vector2d& p_level) {
  return Vector2d(p_level.x(), -p_level.y()) / level.metres_per_unit;
}

PlanDoor DoorOf(const BuildingLevel& level, const BuildingDoor& door) {
  const Vector2d middle(door.T_level_door.x, door.T_level_door.y);
  const double yaw = door.T_level_door.yaw;
  const Vector2d half = Vector2d(-std::sin(yaw), std::cos(yaw)) * (door.width / 2);
  return {.from = ToSheet(level, middle + half), .to = ToSheet(level, middle - half)};
}

PlanShaft ShaftOf(const BuildingLevel& level, const BuildingLift& lift, const Pose2& T_level_cabin) {
  PlanShaft shaft{.kind = ShaftKind::kLift, .outline = {}, .name = lift.name};
  const double x = lift.width / 2, y = lift.depth / 2;
  for (const Vector2d& corner : {Vector2d(-x, -y), Vector2d(x, -y), Vector2d(x, y), Vector2d(-x, y)}) {
    shaft.outline.push_back(ToSheet(level, T_level_cabin * corner));
  }
  return shaft;
}

}  // namespace

PlanGraph PlanOfLevel(const Building& building, std::size_t level_index) {
  const BuildingLevel& level = building.levels[level_index];
  PlanGraph plan;
  plan.metres_per_unit = level.metres_per_unit;
  for (const BuildingWall& wall : level.walls) {
    if (!((wall.b - wall.a).norm() > 0)) continue;
    const int from = static_cast<int>(plan.corners.size());
    plan.corners.push_back({ToSheet(level, wall.a)});
    plan.corners.push_back({ToSheet(level, wall.b)});
    plan.walls.push_back({.from = from, .to = from + 1});
  }
  for (const BuildingDoor& door : level.doors) plan.doors.push_back(DoorOf(level, door));
  for (const BuildingLift& lift : building.lifts) {
    for (const BuildingLift::Stop& stop : lift.stops) {
      if (stop.level == level_index) plan.shafts.push_back(ShaftOf(level, lift, stop.T_level_cabin));
    }
  }
  return plan;
}

}  // namespace enfilade::prior
