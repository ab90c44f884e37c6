// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/campus_yaml.h"

#include <utility>

#include "client/simulator/sensors/noise.h"
#include "client/simulator/strict_yaml.h"
#include "core/base/status_macros.h"
#include "core/geometry/pose2.h"

namespace enfilade::simulator {
namespace {

constexpr double kFar = 1e6;

class CampusReader {
 public:
  absl::StatusOr<Campus> Read(const YAML::Node& root) {
    StrictMap top(root, "the campus", status_);
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
      StrictMap levels(node, "levels", status_);
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
    StrictMap textures(node, "textures", status_);
    if (!node.IsMap()) return;
    for (const auto& entry : node) {
      StrictMap map(entry.second, "texture " + entry.first.Scalar(), status_);
      Texture texture;
      texture.contrast = map.Number("contrast", texture.contrast, 0.0, 2.0);
      texture.brightness = map.Number("brightness", texture.brightness, 0.0, 1.0);
      texture.period = map.Number("period", 0.0, 0.0, 1000.0);
      texture.seed = map.Get<std::uint64_t>("seed", SeedOf(entry.first.Scalar()));
      map.Finish();
      campus_.textures[entry.first.Scalar()] = texture;
    }
  }
  std::string LevelOf(StrictMap& map) { return map.Get<std::string>("level", first_level_); }

  std::vector<Eigen::Vector2d> Outline(StrictMap& map) {
    if (map.Has("polygon")) return map.Points("polygon");
    const std::vector<double> r = map.Numbers("rect", 4);
    if (r[2] <= 0.0 || r[3] <= 0.0) map.Fail(map.Find("rect"), map.what() + ".rect: width and height are not positive");
    return RectangleOutline(r[0], r[1], r[2], r[3], map.Number("yaw_deg", 0.0, -360.0, 360.0) * kDegree);
  }

  void ReadArea(const YAML::Node& node) {
    StrictMap map(node, "area", status_);
    Area area;
    area.id = map.Required<std::string>("id");
    const std::string kind = map.Get<std::string>("kind", "room");
    if (kind != "room" && kind != "corridor" && kind != "outdoor") {
      map.Fail(map.Find("kind"), "area " + area.id + ": kind is room, corridor or outdoor");
    }
    area.kind = kind == "outdoor" ? AreaKind::kOutdoor : kind == "corridor" ? AreaKind::kCorridor : AreaKind::kRoom;
    area.level = LevelOf(map);
    area.outline = Outline(map);
    area.walled = map.Get<bool>("walls", area.indoor());
    area.wall_height = map.Number("height", wall_height_, 0.2, 100.0);
    area.texture = map.Get<std::string>("texture", "");
    map.Each("doors", [&](const YAML::Node& door) { ReadAreaDoor(door, area); });
    map.Finish();
    campus_.areas.push_back(std::move(area));
  }

  // A door in a side of a rectangle: its middle `at` metres from the side's western or southern end.
  void PlaceDoor(StrictMap& map, const Area& area, const std::string& default_side, Door& door) {
    const std::string side = map.Get<std::string>("side", default_side);
    const double width = map.Number("width", 1.0, 0.1, 100.0);
    int begin = 0;
    int end = 0;
    if (side == "south") {
      begin = 0, end = 1;
    } else if (side == "east") {
      begin = 1, end = 2;
    } else if (side == "north") {
      begin = 3, end = 2;
    } else if (side == "west") {
      begin = 0, end = 3;
    } else {
      return map.Fail(map.Find("side"), map.what() + ": side is south, east, north or west");
    }
    if (area.outline.size() != 4) {
      return map.Fail(map.Find("side"), map.what() + ": sides are of rectangles; give from and to under doors");
    }
    const Eigen::Vector2d p = area.outline[static_cast<std::size_t>(begin)];
    const Eigen::Vector2d q = area.outline[static_cast<std::size_t>(end)];
    const double length = (q - p).norm();
    const double at = map.Number("at", length / 2.0, 0.0, kFar);
    if (at - width / 2.0 < -1e-9 || at + width / 2.0 > length + 1e-9) {
      map.Fail(map.Find("at"), map.what() + ": the door lies beyond its side");
    }
    const Eigen::Vector2d on = (q - p) / length;
    door.a = p + (at - width / 2.0) * on;
    door.b = p + (at + width / 2.0) * on;
  }

  void ReadDoorState(StrictMap& map, Door& door) {
    const std::string state = map.Get<std::string>("state", "open");
    if (state != "open" && state != "closed" && state != "glass") {
      map.Fail(map.Find("state"), map.what() + ": state is open, closed or glass");
    }
    door.state = state == "closed" ? DoorState::kClosed : state == "glass" ? DoorState::kGlass : DoorState::kOpen;
    door.height = map.Number("height", door.height, 0.5, 50.0);
    door.opening = map.Get<bool>("opening", false);
    if (map.Has("leaf_deg")) door.leaf = map.Number("leaf_deg", 90.0, -180.0, 180.0) * kDegree;
    map.Finish();
    campus_.doors.push_back(door);
  }

  void ReadAreaDoor(const YAML::Node& node, const Area& area) {
    Door door;
    StrictMap map(node, "a door of area " + area.id, status_);
    door.id = map.Required<std::string>("id");
    door.level = area.level;
    PlaceDoor(map, area, "south", door);
    ReadDoorState(map, door);
  }

  void ReadDoor(const YAML::Node& node) {
    Door door;
    StrictMap map(node, "door", status_);
    door.id = map.Required<std::string>("id");
    door.level = LevelOf(map);
    door.a = map.Point("from");
    door.b = map.Point("to");
    ReadDoorState(map, door);
  }

  void ReadLift(const YAML::Node& node) {
    StrictMap map(node, "lift", status_);
    Lift lift;
    lift.id = map.Required<std::string>("id");
    Area cabin;
    cabin.id = lift.id;
    cabin.outline = Outline(map);
    cabin.wall_height = map.Number("height", 2.4, 1.0, 10.0);
    cabin.texture = map.Get<std::string>("texture", "");
    Door door;
    PlaceDoor(map, cabin, "south", door);
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
    StrictMap map(node, "wall", status_);
    Wall wall;
    wall.level = LevelOf(map);
    wall.points = map.Points("points");
    wall.bottom = map.Number("bottom", 0.0, 0.0, 100.0);
    wall.top = map.Number("height", wall_height_, 0.05, 100.0);
    wall.glass = map.Get<bool>("glass", false);
    wall.thickness = map.Number("thickness", wall.glass ? 0.0 : campus_.wall_thickness, 0.0, 5.0);
    wall.texture = map.Get<std::string>("texture", "");
    map.Finish();
    campus_.walls.push_back(std::move(wall));
  }

  void ReadDrawing(const YAML::Node& node) {
    StrictMap map(node, "drawing", status_);
    const std::string level = LevelOf(map);
    const Eigen::Vector2d origin = map.Has("at") ? map.Point("at") : Eigen::Vector2d::Zero();
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
    StrictMap map(node, "box", status_);
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
    StrictMap map(node, "pillar", status_);
    Box box;
    box.level = LevelOf(map);
    const Eigen::Vector2d at = map.Point("at");
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
    StrictMap map(node, "person", status_);
    Person person;
    person.level = LevelOf(map);
    person.path = map.Points("path");
    person.speed = map.Number("speed", person.speed, 0.0, 10.0);
    person.phase = map.Number("phase", 0.0, 0.0, kFar);
    person.radius = map.Number("radius", person.radius, 0.05, 2.0);
    map.Finish();
    campus_.people.push_back(std::move(person));
  }

  void ReadRobot(const YAML::Node& node) {
    StrictMap map(node, "robot", status_);
    Robot robot;
    robot.id = map.Required<std::string>("id");
    robot.level = LevelOf(map);
    robot.laps = map.Get<int>("laps", 1);
    robot.returns = map.Get<bool>("returns", false);
    if (map.Has("speed")) robot.speed = map.Number("speed", 0.6, 0.01, 5.0);
    map.Each("route", [&](const YAML::Node& step) { robot.route.push_back(ReadStep(step, map)); });
    map.Finish();
    campus_.robots.push_back(std::move(robot));
  }

  RouteStep ReadStep(const YAML::Node& node, StrictMap& robot) {
    RouteStep step;
    if (node.IsSequence()) {
      const std::vector<double> numbers = robot.NumbersOf(node, "route", 2);
      step.point = {numbers[0], numbers[1]};
      return step;
    }
    StrictMap map(node, "a step of the route", status_);
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
  try {
    return CampusReader().Read(YAML::Load(std::string(yaml)));
  } catch (const YAML::Exception& error) {
    return InvalidArgument("line {}: {}", error.mark.line + 1, error.msg);
  }
}

}  // namespace enfilade::simulator
