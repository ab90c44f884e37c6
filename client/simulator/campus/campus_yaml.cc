// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/campus/campus_yaml.h"

#include <utility>

#include "client/simulator/campus/drawing.h"
#include "client/simulator/campus/shapes_yaml.h"
#include "core/base/noise.h"
#include "core/base/status_macros.h"
#include "core/geometry/pose2.h"
#include "core/options/strict_mapping.h"

namespace enfilade::simulator {
namespace {

using yaml_options::StrictMapping;

constexpr double kMaxPhase = 1e6;  // s

class CampusReader {
 public:
  absl::StatusOr<Campus> Read(const YAML::Node& root) {
    StrictMapping top(root, "the campus", status_);
    campus_.name = top.Get<std::string>("campus", "campus");
    campus_.wall_thickness = top.Number("wall_thickness", 0.15, 0.0, 2.0);
    wall_height_ = top.Number("wall_height", 3.0, 0.5, 50.0);
    campus_.texture_seed = top.Get<std::uint64_t>("texture_seed", 1);
    ReadLevels(top.Find("levels"));
    ReadTextures(top.Find("textures"));
    top.Each("lifts", [&](const YAML::Node& node) { ReadLift(node); });
    top.Each("areas", [&](const YAML::Node& node) { ReadArea(node); });
    top.Each("doors", [&](const YAML::Node& node) { ReadDoor(node); });
    top.Each("walls", [&](const YAML::Node& node) { ReadWall(node); });
    top.Each("drawings", [&](const YAML::Node& node) { ReadDrawing(node); });
    top.Each("boxes", [&](const YAML::Node& node) { ReadBox(node); });
    top.Each("pillars", [&](const YAML::Node& node) { ReadPillar(node); });
    top.Each("people", [&](const YAML::Node& node) { ReadPerson(node); });
    top.Each("robots", [&](const YAML::Node& node) { ReadRobot(node); });
    top.Finish();
    ENFILADE_RETURN_IF_ERROR(status_);
    ENFILADE_RETURN_IF_ERROR(Validate(campus_));
    return std::move(campus_);
  }

 private:
  void ReadLevels(const YAML::Node& node) {
    if (node.IsDefined()) {
      StrictMapping levels(node, "levels", status_);
      if (!node.IsMap()) return;
      for (const auto& entry : node) {
        const std::string id = entry.first.Scalar();
        campus_.levels[id] = levels.Number(id, 0.0, -1000.0, 1000.0);
      }
    }
    if (campus_.levels.empty()) campus_.levels["ground"] = 0.0;
    first_level_ = node.IsDefined() && node.IsMap() && node.size() > 0 ? node.begin()->first.Scalar() : "ground";
  }

  void ReadTextures(const YAML::Node& node) {
    if (!node.IsDefined()) return;
    StrictMapping textures(node, "textures", status_);
    if (!node.IsMap()) return;
    for (const auto& entry : node) {
      StrictMapping map(entry.second, "texture " + entry.first.Scalar(), status_);
      Texture texture;
      texture.contrast = map.Number("contrast", texture.contrast, 0.0, 2.0);
      texture.brightness = map.Number("brightness", texture.brightness, 0.0, 1.0);
      texture.period = map.Number("period", 0.0, 0.0, 1000.0);
      texture.seed = map.Get<std::uint64_t>("seed", SeedOf(entry.first.Scalar()));
      map.Finish();
      campus_.textures[entry.first.Scalar()] = texture;
    }
  }
  std::string LevelOf(StrictMapping& map) { return map.Get<std::string>("level", first_level_); }

  void ReadArea(const YAML::Node& node) {
    StrictMapping map(node, "area", status_);
    Area area;
    area.id = map.Required<std::string>("id");
    area.kind = map.Choice<AreaKind>(
        "kind", {{"room", AreaKind::kRoom}, {"corridor", AreaKind::kCorridor}, {"outdoor", AreaKind::kOutdoor}},
        AreaKind::kRoom);
    area.level = LevelOf(map);
    area.outline = Outline(map);
    area.walled = map.Get<bool>("walls", area.indoor());
    area.wall_height = map.Number("height", wall_height_, 0.2, 100.0);
    area.texture = map.Get<std::string>("texture", "");
    map.Each("doors", [&](const YAML::Node& door) { ReadAreaDoor(door, area); });
    map.Finish();
    campus_.areas.push_back(std::move(area));
  }

  void ReadDoorState(StrictMapping& map, Door& door) {
    door.state = map.Choice<DoorState>(
        "state", {{"open", DoorState::kOpen}, {"closed", DoorState::kClosed}, {"glass", DoorState::kGlass}},
        DoorState::kOpen);
    door.height = map.Number("height", door.height, 0.5, 50.0);
    door.opening = map.Get<bool>("opening", false);
    if (map.Has("leaf_deg")) door.leaf = map.Number("leaf_deg", 90.0, -180.0, 180.0) * kDegree;
    map.Finish();
    campus_.doors.push_back(door);
  }

  void ReadAreaDoor(const YAML::Node& node, const Area& area) {
    Door door;
    StrictMapping map(node, "a door of area " + area.id, status_);
    door.id = map.Required<std::string>("id");
    door.level = area.level;
    PlaceDoor(map, area, door);
    ReadDoorState(map, door);
  }

  void ReadDoor(const YAML::Node& node) {
    Door door;
    StrictMapping map(node, "door", status_);
    door.id = map.Required<std::string>("id");
    door.level = LevelOf(map);
    door.a = Point(map, "from");
    door.b = Point(map, "to");
    ReadDoorState(map, door);
  }

  void ReadLift(const YAML::Node& node) {
    StrictMapping map(node, "lift", status_);
    Lift lift;
    lift.id = map.Required<std::string>("id");
    Area cabin;
    cabin.id = lift.id;
    cabin.outline = Outline(map);
    cabin.wall_height = map.Number("height", 2.4, 1.0, 10.0);
    cabin.texture = map.Get<std::string>("texture", "");
    Door door;
    PlaceDoor(map, cabin, door);
    map.Each("levels", [&](const YAML::Node& level) {
      if (!level.IsScalar()) return map.Fail(level, "lift.levels: expected names");
      lift.levels.push_back(level.Scalar());
    });
    map.Finish();
    for (const std::string& level : lift.levels) {
      cabin.level = door.level = level;
      door.id = lift.id + "/" + level;
      campus_.areas.push_back(cabin);
      campus_.doors.push_back(door);
    }
    campus_.lifts.push_back(std::move(lift));
  }

  void ReadWall(const YAML::Node& node) {
    StrictMapping map(node, "wall", status_);
    Wall wall;
    wall.level = LevelOf(map);
    wall.points = Points(map, "points");
    wall.bottom = map.Number("bottom", 0.0, 0.0, 100.0);
    wall.top = map.Number("height", wall_height_, 0.05, 100.0);
    wall.glass = map.Get<bool>("glass", false);
    wall.thickness = map.Number("thickness", wall.glass ? 0.0 : campus_.wall_thickness, 0.0, 5.0);
    wall.texture = map.Get<std::string>("texture", "");
    map.Finish();
    campus_.walls.push_back(std::move(wall));
  }

  void ReadDrawing(const YAML::Node& node) {
    StrictMapping map(node, "drawing", status_);
    const std::string level = LevelOf(map);
    const Eigen::Vector2d origin = map.Has("at") ? Point(map, "at") : Eigen::Vector2d::Zero();
    absl::StatusOr<Drawing> drawing =
        ParseDrawing(map.Required<std::string>("rows"), map.Number("cell", 0.25, 0.01, 100.0), origin);
    const double height = map.Number("height", wall_height_, 0.05, 100.0);
    const std::string texture = map.Get<std::string>("texture", "");
    map.Finish();
    if (!drawing.ok()) return map.Fail(node, std::string(drawing.status().message()));
    for (Wall& wall : drawing->walls) {
      wall.level = level;
      wall.top = height;
      wall.texture = texture;
      campus_.walls.push_back(std::move(wall));
    }
    points_.merge(drawing->points);
  }

  void ReadBox(const YAML::Node& node) {
    StrictMapping map(node, "box", status_);
    Box box;
    box.level = LevelOf(map);
    box.outline = Outline(map);
    box.bottom = map.Number("bottom", 0.0, 0.0, 100.0);
    box.top = map.Number("height", box.top, 0.01, 100.0);
    box.texture = map.Get<std::string>("texture", "");
    map.Finish();
    campus_.boxes.push_back(std::move(box));
  }

  void ReadPillar(const YAML::Node& node) {
    StrictMapping map(node, "pillar", status_);
    Box box;
    box.level = LevelOf(map);
    const Eigen::Vector2d at = Point(map, "at");
    const double radius = map.Number("radius", 0.25, 0.01, 50.0);
    constexpr int kCorners = 12;
    for (int i = 0; i < kCorners; ++i) {
      const double angle = 2.0 * M_PI * i / kCorners;
      box.outline.emplace_back(at.x() + radius * std::cos(angle), at.y() + radius * std::sin(angle));
    }
    box.top = map.Number("height", wall_height_, 0.01, 100.0);
    box.texture = map.Get<std::string>("texture", "");
    map.Finish();
    campus_.boxes.push_back(std::move(box));
  }

  void ReadPerson(const YAML::Node& node) {
    StrictMapping map(node, "person", status_);
    Person person;
    person.level = LevelOf(map);
    person.path = Points(map, "path");
    person.speed = map.Number("speed", person.speed, 0.0, 10.0);
    person.phase = map.Number("phase", 0.0, 0.0, kMaxPhase);
    person.radius = map.Number("radius", person.radius, 0.05, 2.0);
    map.Finish();
    campus_.people.push_back(std::move(person));
  }

  void ReadRobot(const YAML::Node& node) {
    StrictMapping map(node, "robot", status_);
    Robot robot;
    robot.id = map.Required<std::string>("id");
    robot.level = LevelOf(map);
    robot.laps = map.Get<int>("laps", 1);
    robot.returns = map.Get<bool>("returns", false);
    if (map.Has("speed")) robot.speed = map.Number("speed", 0.6, 0.01, 5.0);
    map.Each("route", [&](const YAML::Node& step) { robot.route.push_back(ReadStep(step, map)); });
    map.Each("back", [&](const YAML::Node& step) { robot.back.push_back(ReadStep(step, map)); });
    map.Finish();
    campus_.robots.push_back(std::move(robot));
  }

  RouteStep ReadStep(const YAML::Node& node, StrictMapping& robot) {
    RouteStep step;
    if (node.IsSequence()) {
      const std::vector<double> numbers = robot.NumbersOf(node, "route", 2);
      step.point = {numbers[0], numbers[1]};
      return step;
    }
    StrictMapping map(node, "a step of the route", status_);
    if (map.Has("point")) {
      const auto found = points_.find(map.Get<std::string>("point", ""));
      if (found == points_.end()) {
        map.Fail(node, "no drawing has the point \"" + map.Get<std::string>("point", "") + "\"");
      } else {
        step.point = found->second;
      }
    } else if (map.Has("door")) {
      step.kind = RouteStep::Kind::kDoor;
      step.name = map.Get<std::string>("door", "");
    } else if (map.Has("wait")) {
      step.kind = RouteStep::Kind::kWait;
      step.value = map.Number("wait", 0.0, 0.0, 86400.0);
    } else if (map.Has("turn_to_deg")) {
      step.kind = RouteStep::Kind::kTurnTo;
      step.value = map.Number("turn_to_deg", 0.0, -360.0, 360.0) * kDegree;
    } else {
      step.kind = RouteStep::Kind::kLift;
      step.name = map.Required<std::string>("lift");
      step.level = map.Required<std::string>("to");
      step.value = map.Number("seconds", 8.0, 0.0, 3600.0);
    }
    map.Finish();
    return step;
  }

  absl::Status status_;
  Campus campus_;
  double wall_height_ = 3.0;
  std::string first_level_ = "ground";
  std::map<std::string, Eigen::Vector2d> points_;  // of the drawings
};

}  // namespace

absl::StatusOr<Campus> ParseCampus(std::string_view yaml) {
  return yaml_options::ReadYaml(yaml, "", [](const YAML::Node& root) { return CampusReader().Read(root); });
}

}  // namespace enfilade::simulator
