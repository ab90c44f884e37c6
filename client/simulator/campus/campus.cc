// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/campus/campus.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/base/error.h"
#include "core/base/ids.h"
#include "core/base/status_macros.h"

namespace enfilade::simulator {
namespace {

template <typename T>
const T* FindById(const std::vector<T>& all, const std::string& id) {
  const auto found = std::find_if(all.begin(), all.end(), [&](const T& one) { return one.id == id; });
  return found == all.end() ? nullptr : &*found;
}

class Check {
 public:
  explicit Check(const Campus& campus) : campus_(campus) {}

  absl::Status Run() {
    ENFILADE_RETURN_IF_ERROR(Unique("area", campus_.areas, true));
    ENFILADE_RETURN_IF_ERROR(Unique("door", campus_.doors, false));
    ENFILADE_RETURN_IF_ERROR(Unique("lift", campus_.lifts, false));
    ENFILADE_RETURN_IF_ERROR(Unique("robot", campus_.robots, false));
    for (const Area& area : campus_.areas) {
      const std::string what = "area " + area.id;
      ENFILADE_RETURN_IF_ERROR(Level(what, area.level));
      ENFILADE_RETURN_IF_ERROR(TextureOf(what, area.texture));
      if (area.outline.size() < 3) return InvalidArgument("{}: an outline needs at least three corners", what);
    }
    for (const Door& door : campus_.doors) {
      ENFILADE_RETURN_IF_ERROR(Level("door " + door.id, door.level));
      if (!(door.width() >= 0.1)) return InvalidArgument("door {}: its jambs are less than 0.1 m apart", door.id);
    }
    for (const Wall& wall : campus_.walls) {
      ENFILADE_RETURN_IF_ERROR(Level("a wall", wall.level));
      ENFILADE_RETURN_IF_ERROR(TextureOf("a wall", wall.texture));
      if (wall.points.size() < 2) return InvalidArgument("a wall needs at least two points");
    }
    for (const Box& box : campus_.boxes) {
      ENFILADE_RETURN_IF_ERROR(Level("a box", box.level));
      ENFILADE_RETURN_IF_ERROR(TextureOf("a box", box.texture));
    }
    for (const Person& person : campus_.people) {
      ENFILADE_RETURN_IF_ERROR(Level("a person", person.level));
      if (person.path.empty()) return InvalidArgument("a person's path has no points");
    }
    for (const Robot& robot : campus_.robots) ENFILADE_RETURN_IF_ERROR(Route(robot));
    return absl::OkStatus();
  }

 private:
  // Areas may share an id only if they are the cabins of one lift on different levels.
  template <typename T>
  absl::Status Unique(const char* what, const std::vector<T>& all, bool cabins) const {
    std::set<std::string> seen;
    for (const T& one : all) {
      if (one.id.empty()) return InvalidArgument("a {} has no id", what);
      if (seen.insert(one.id).second || (cabins && campus_.FindLift(one.id))) continue;
      return InvalidArgument("there are two {}s \"{}\"", what, one.id);
    }
    return absl::OkStatus();
  }
  absl::Status Level(const std::string& what, const std::string& level) const {
    if (campus_.levels.contains(level)) return absl::OkStatus();
    return InvalidArgument("{}: there is no level \"{}\"", what, level);
  }
  absl::Status TextureOf(const std::string& what, const std::string& texture) const {
    if (texture.empty() || campus_.textures.contains(texture)) return absl::OkStatus();
    return InvalidArgument("{}: there is no texture \"{}\"", what, texture);
  }
  absl::Status Route(const Robot& robot) const {
    const std::string what = "robot " + robot.id;
    if (!IsValidResourceId(robot.id)) return InvalidArgument("{}: an id has only a to z, 0 to 9 and hyphens", what);
    ENFILADE_RETURN_IF_ERROR(Level(what, robot.level));
    if (robot.route.size() < 2 || robot.route[0].kind != RouteStep::Kind::kPoint) {
      return InvalidArgument("{}: a route begins with a point, its start, and needs at least one more step", what);
    }
    if (robot.laps < 1 || robot.laps > 1000)
      return InvalidArgument("{}: laps is {}: expected 1 to 1000", what, robot.laps);
    std::vector<RouteStep> steps = robot.route;
    steps.insert(steps.end(), robot.back.begin(), robot.back.end());
    for (const RouteStep& step : steps) {
      if (step.kind == RouteStep::Kind::kDoor && !campus_.FindDoor(step.name)) {
        return InvalidArgument("{}: there is no door \"{}\"", what, step.name);
      }
      if (step.kind != RouteStep::Kind::kLift) continue;
      const Lift* lift = campus_.FindLift(step.name);
      if (!lift) return InvalidArgument("{}: there is no lift \"{}\"", what, step.name);
      if (std::find(lift->levels.begin(), lift->levels.end(), step.level) == lift->levels.end()) {
        return InvalidArgument("{}: lift {} does not stop at \"{}\"", what, step.name, step.level);
      }
    }
    return absl::OkStatus();
  }

  const Campus& campus_;
};

}  // namespace

const Area* Campus::FindArea(const std::string& id) const { return FindById(areas, id); }
const Door* Campus::FindDoor(const std::string& id) const { return FindById(doors, id); }
const Lift* Campus::FindLift(const std::string& id) const { return FindById(lifts, id); }
const Robot* Campus::FindRobot(const std::string& id) const { return FindById(robots, id); }

const Area* Campus::AreaAt(const std::string& level, const Eigen::Vector2d& point) const {
  for (const Area& area : areas) {
    if (area.level == level && Contains(area.outline, point)) return &area;
  }
  return nullptr;
}

absl::Status Validate(const Campus& campus) { return Check(campus).Run(); }

bool Contains(const std::vector<Eigen::Vector2d>& outline, const Eigen::Vector2d& point) {
  bool inside = false;
  for (std::size_t i = 0, j = outline.size() - 1; i < outline.size(); j = i++) {
    const Eigen::Vector2d& p = outline[i];
    const Eigen::Vector2d& q = outline[j];
    if ((p.y() > point.y()) == (q.y() > point.y())) continue;
    if (point.x() < p.x() + (q.x() - p.x()) * (point.y() - p.y()) / (q.y() - p.y())) inside = !inside;
  }
  return inside;
}

std::vector<Eigen::Vector2d> RectangleOutline(double x, double y, double width, double height, double yaw) {
  const Eigen::Vector2d middle(x + width / 2.0, y + height / 2.0);
  std::vector<Eigen::Vector2d> outline;
  for (const auto& [sx, sy] : {std::pair{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}}) {
    const double dx = sx * width;
    const double dy = sy * height;
    outline.emplace_back(middle.x() + dx * std::cos(yaw) - dy * std::sin(yaw),
                         middle.y() + dx * std::sin(yaw) + dy * std::cos(yaw));
  }
  return outline;
}

}  // namespace enfilade::simulator
