// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/campus/building_campus.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "client/simulator/campus/building_tour.h"
#include "client/simulator/campus/floor_areas.h"
#include "client/simulator/campus/wall_gaps.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/geometry/pose2.h"
#include "fmt/format.h"

namespace enfilade::simulator {
namespace {

constexpr double kLevelHeight = 4.0;    // m
constexpr double kWallThickness = 0.1;  // m
constexpr double kLeastArea = 2.0;      // m^2
constexpr double kLargest = 200.0;      // m
constexpr double kBesideDoor = 0.4;     // m
constexpr double kJamb = 0.05;          // m: a closed door reaches so far into its wall

class BuildingDrawing {
 public:
  explicit BuildingDrawing(const prior::Building& building) : building_(building) {
    campus_.name = building.name;
    campus_.wall_thickness = kWallThickness;
  }

  absl::StatusOr<Campus> Draw() {
    barriers_.resize(building_.levels.size());
    for (std::size_t i = 0; i < building_.levels.size(); ++i) {
      campus_.levels[building_.levels[i].name] = kLevelHeight * static_cast<double>(i);
      DrawLevel(i);
    }
    for (const prior::BuildingLift& lift : building_.lifts) DrawLift(lift);
    for (std::size_t i = 0; i < building_.levels.size(); ++i) AddGaps(i);
    for (std::size_t i = 0; i < building_.levels.size(); ++i) ENFILADE_RETURN_IF_ERROR(DivideLevel(i));
    if (campus_.areas.size() == cabins_) return InvalidArgument("{}: its walls enclose no areas", campus_.name);
    std::erase_if(campus_.doors, [this](const Door& door) { return gaps_.contains(door.id) && !Divides(door); });
    for (Door& door : campus_.doors) {
      if (!LeadsSomewhere(door)) door.state = DoorState::kClosed;
    }
    ENFILADE_RETURN_IF_ERROR(PlanTour(campus_));
    ENFILADE_RETURN_IF_ERROR(Validate(campus_));
    return std::move(campus_);
  }

 private:
  // The level in the campus, which is the frame of the first level that it shares a lift with, or its own.
  Pose2 PlaceOf(std::size_t level) const {
    if (level == 0) return {};
    for (const prior::BuildingLift& lift : building_.lifts) {
      const auto stop = [&](std::size_t at) {
        return std::find_if(lift.stops.begin(), lift.stops.end(), [at](const auto& one) { return one.level == at; });
      };
      if (stop(0) == lift.stops.end() || stop(level) == lift.stops.end()) continue;
      return stop(0)->T_level_cabin * Inverse(stop(level)->T_level_cabin);
    }
    return {};
  }

  void AddDoor(std::size_t level, std::string id, const Pose2& T_campus_door, double width) {
    while (!door_ids_.insert(id).second) id += "+";
    Door door;
    door.id = id;
    door.level = building_.levels[level].name;
    door.a = T_campus_door * Eigen::Vector2d(0.0, -width / 2.0);
    door.b = T_campus_door * Eigen::Vector2d(0.0, width / 2.0);
    barriers_[level].emplace_back(T_campus_door * Eigen::Vector2d(0.0, -width / 2.0 - kJamb),
                                  T_campus_door * Eigen::Vector2d(0.0, width / 2.0 + kJamb));
    campus_.doors.push_back(std::move(door));
  }

  void DrawLevel(std::size_t index) {
    const prior::BuildingLevel& level = building_.levels[index];
    const Pose2 T_campus_level = PlaceOf(index);
    for (const prior::BuildingWall& drawn : level.walls) {
      Wall wall;
      wall.level = level.name;
      wall.points = {T_campus_level * drawn.a, T_campus_level * drawn.b};
      wall.thickness = kWallThickness;
      barriers_[index].emplace_back(wall.points[0], wall.points[1]);
      campus_.walls.push_back(std::move(wall));
    }
    for (std::size_t i = 0; i < level.doors.size(); ++i) {
      const prior::BuildingDoor& door = level.doors[i];
      if (door.width < 0.1) continue;
      AddDoor(index, door.name.empty() ? fmt::format("{}-door{}", level.name, i + 1) : door.name,
              T_campus_level * door.T_level_door, door.width);
    }
  }

  // Doorways that have no door in the file.
  void AddGaps(std::size_t index) {
    const std::string& level = building_.levels[index].name;
    std::vector<Barrier> walls;
    std::vector<Barrier> doors;
    for (const Wall& wall : campus_.walls) {
      if (wall.level == level) walls.emplace_back(wall.points[0], wall.points[1]);
    }
    for (const Door& door : campus_.doors) {
      if (door.level == level) doors.emplace_back(door.a, door.b);
    }
    int count = 0;
    for (const auto& [a, b] : GapsBetween(walls, doors)) {
      const Eigen::Vector2d middle = (a + b) / 2.0;
      const double through = std::atan2(b.y() - a.y(), b.x() - a.x()) + M_PI / 2.0;
      AddDoor(index, fmt::format("{}-gap{}", level, ++count), {middle.x(), middle.y(), through}, (b - a).norm());
      gaps_.insert(campus_.doors.back().id);
    }
  }

  void DrawLift(const prior::BuildingLift& drawn) {
    if (drawn.width < 0.5 || drawn.depth < 0.5 || drawn.doors.empty()) return;
    Lift lift;
    lift.id = drawn.name;
    for (const prior::BuildingLift::Stop& stop : drawn.stops) {
      const std::string& level = building_.levels[stop.level].name;
      const Pose2 T_campus_cabin = PlaceOf(stop.level) * stop.T_level_cabin;
      Area cabin;
      cabin.id = lift.id;
      cabin.level = level;
      cabin.wall_height = 2.4;
      for (const Eigen::Vector2d& corner :
           RectangleOutline(-drawn.width / 2.0, -drawn.depth / 2.0, drawn.width, drawn.depth)) {
        cabin.outline.push_back(T_campus_cabin * corner);
      }
      for (std::size_t i = 0; i < cabin.outline.size(); ++i) {
        barriers_[stop.level].emplace_back(cabin.outline[i], cabin.outline[(i + 1) % cabin.outline.size()]);
      }
      lift.levels.push_back(level);
      AddDoor(stop.level, lift.id + "/" + level, T_campus_cabin * drawn.doors[0].T_level_door, drawn.doors[0].width);
      campus_.areas.push_back(std::move(cabin));
    }
    campus_.lifts.push_back(std::move(lift));
    cabins_ = campus_.areas.size();
  }

  absl::Status DivideLevel(std::size_t index) {
    const std::string& level = building_.levels[index].name;
    for (const auto& [a, b] : barriers_[index]) {
      if ((a - barriers_[index][0].first).norm() > kLargest || (b - barriers_[index][0].first).norm() > kLargest) {
        return InvalidArgument("level {}: it is larger than {} m: is it measured wrongly?", level, kLargest);
      }
    }
    std::vector<Area> areas;
    for (FloorArea& piece : DivideFloor(barriers_[index], kLeastArea)) {
      const Area* there = campus_.AreaAt(level, piece.inside);
      if (there && campus_.FindLift(there->id)) continue;
      Area area;
      area.id = fmt::format("{}-{}", level, areas.size() + 1);
      area.level = level;
      area.outline = std::move(piece.outline);
      area.walled = false;
      areas.push_back(std::move(area));
    }
    // A room that another one surrounds comes before it.
    campus_.areas.insert(campus_.areas.end(), areas.rbegin(), areas.rend());
    return absl::OkStatus();
  }

  // The areas on both sides of a door.
  std::pair<const Area*, const Area*> Beside(const Door& door) const {
    const Eigen::Vector2d on = (door.b - door.a).normalized();
    const Eigen::Vector2d through(-on.y(), on.x());
    return {campus_.AreaAt(door.level, door.middle() + kBesideDoor * through),
            campus_.AreaAt(door.level, door.middle() - kBesideDoor * through)};
  }
  bool LeadsSomewhere(const Door& door) const { return Beside(door).first && Beside(door).second; }
  bool Divides(const Door& door) const { return LeadsSomewhere(door) && Beside(door).first != Beside(door).second; }

  const prior::Building& building_;
  Campus campus_;
  std::size_t cabins_ = 0;  // areas
  std::set<std::string> door_ids_;
  std::set<std::string> gaps_;                  // doors that are gaps in the file
  std::vector<std::vector<Barrier>> barriers_;  // of each level
};

}  // namespace

absl::StatusOr<Campus> CampusOf(const prior::Building& building) { return BuildingDrawing(building).Draw(); }

}  // namespace enfilade::simulator
