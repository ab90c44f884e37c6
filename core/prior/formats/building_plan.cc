// SPDX-License-Identifier: Apache-2.0
#include "core/prior/formats/building_plan.h"

#include <cmath>
#include <cstddef>
#include <string>

#include "fmt/format.h"
#include "yaml-cpp/yaml.h"

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

std::string WriteBuildingPlan(const PlanGraph& plan, const std::string& level, double metres_per_unit) {
  YAML::Emitter yaml;
  const auto vertex = [&](const Vector2d& point, const std::string& name) {
    yaml << YAML::Flow << YAML::BeginSeq << point.x() << point.y() << 0.0 << name << YAML::EndSeq;
  };
  const auto typed = [&](const char* key, int type, const auto& value) {
    yaml << YAML::Key << key << YAML::Value << YAML::Flow << YAML::BeginSeq << type << value << YAML::EndSeq;
  };
  yaml << YAML::BeginMap << YAML::Key << "name" << YAML::Value << level;
  yaml << YAML::Key << "levels" << YAML::Value << YAML::BeginMap << YAML::Key << level << YAML::Value << YAML::BeginMap;
  yaml << YAML::Key << "elevation" << YAML::Value << 0.0;
  yaml << YAML::Key << "vertices" << YAML::Value << YAML::BeginSeq;
  for (const PlanCorner& corner : plan.corners) vertex(corner.point, "");
  for (const PlanDoor& door : plan.doors) vertex(door.from, ""), vertex(door.to, "");
  yaml << YAML::EndSeq << YAML::Key << "walls" << YAML::Value << YAML::BeginSeq;
  const PlanWall* longest = nullptr;
  for (const PlanWall& wall : plan.walls) {
    yaml << YAML::Flow << YAML::BeginSeq << wall.from << wall.to << YAML::BeginMap << YAML::EndMap << YAML::EndSeq;
    if (longest == nullptr || LengthOf(plan, wall) > LengthOf(plan, *longest)) longest = &wall;
  }
  yaml << YAML::EndSeq << YAML::Key << "doors" << YAML::Value << YAML::BeginSeq;
  for (std::size_t i = 0; i < plan.doors.size(); ++i) {
    const std::size_t first = plan.corners.size() + 2 * i;
    yaml << YAML::Flow << YAML::BeginSeq << first << first + 1 << YAML::BeginMap;
    typed("name", 1, fmt::format("door{}", i + 1));
    typed("type", 1, "hinged");
    yaml << YAML::EndMap << YAML::EndSeq;
  }
  yaml << YAML::EndSeq << YAML::Key << "measurements" << YAML::Value << YAML::BeginSeq;
  if (longest != nullptr) {
    yaml << YAML::Flow << YAML::BeginSeq << longest->from << longest->to << YAML::BeginMap;
    typed("distance", 3, LengthOf(plan, *longest) * metres_per_unit);
    yaml << YAML::EndMap << YAML::EndSeq;
  }
  yaml << YAML::EndSeq << YAML::EndMap << YAML::EndMap << YAML::EndMap;
  return std::string(yaml.c_str()) + "\n";
}

}  // namespace enfilade::prior
