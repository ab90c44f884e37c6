// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "client/simulator/campus/building_draft.h"
#include "client/simulator/world/free_ground.h"
#include "client/simulator/world/world.h"

namespace enfilade::simulator {
namespace {

// Plans around what stands in the finished building.
class LatePlanner {
 public:
  LatePlanner(BuildingDraft& draft, std::uint64_t seed)
      : draft_(draft), noise_(Mix(seed, 0x2B07)), world_(draft.campus), ground_(world_.level("ground")) {}

  // From the end of the route back to its start, through doors.
  void AddWayBack(Robot& robot) const {
    FreeGround::Box box{robot.route[0].point, robot.route[0].point};
    for (const RouteStep& step : robot.route) {
      box.lower = box.lower.cwiseMin(step.point - Eigen::Vector2d(2.0, 2.0));
      box.upper = box.upper.cwiseMax(step.point + Eigen::Vector2d(2.0, 2.0));
    }
    for (const Eigen::Vector2d& point : ground_.Way(robot.route.back().point, robot.route[0].point, box)) {
      robot.back.push_back(StepTo(point));
    }
    if (!robot.back.empty()) robot.back.pop_back();  // the start itself, where a lap begins
  }

  // Starts in the same space as the first robot and drives through the least used doors.
  Robot SecondRobot() {
    Robot robot;
    robot.id = "robot2";
    robot.level = "ground";
    int space = SpaceOf(draft_.campus.robots[0].route[0].point);
    robot.route.push_back(StepTo(PointInside(space).value_or(draft_.campus.robots[0].route[0].point)));
    for (PassableDoor& door : draft_.passable) door.used = 0;
    for (int i = 0; i < draft_.options.passages; ++i) {
      std::vector<std::size_t> choices = DoorsOf(space);
      bool passed = false;
      while (!choices.empty() && !passed) {
        const std::size_t chosen = TakeLeastUsed(choices);
        passed = GoThrough(draft_.passable[chosen], space, robot);
        ++draft_.passable[chosen].used;
      }
      if (!passed) break;
    }
    if (robot.route.size() < 2) robot.route.push_back(robot.route[0]);
    return robot;
  }

 private:
  static RouteStep StepTo(const Eigen::Vector2d& point) {
    RouteStep step;
    step.point = point;
    return step;
  }

  int SpaceOf(const Eigen::Vector2d& point) const {
    const auto holds = [&](const Rect& rect) { return rect.Holds(point, 0.0); };
    return static_cast<int>(std::find_if(draft_.spaces.begin(), draft_.spaces.end(), holds) - draft_.spaces.begin());
  }

  std::optional<Eigen::Vector2d> PointInside(int space) {
    const Rect& rect = draft_.space(space);
    const double margin = std::min({0.8, rect.width / 2.0 - 0.2, rect.height / 2.0 - 0.2});
    const double width = rect.width > 24.0 ? 12.0 : rect.width;  // only the near part of the yard
    for (int attempt = 0; attempt < 50; ++attempt) {
      const Eigen::Vector2d point(noise_.Uniform(rect.x + margin, rect.x + width - margin),
                                  noise_.Uniform(rect.y + margin, rect.y + rect.height - margin));
      if (ground_.IsFree(point)) return point;
    }
    return std::nullopt;
  }

  std::vector<std::size_t> DoorsOf(int space) const {
    std::vector<std::size_t> doors;
    for (std::size_t i = 0; i < draft_.passable.size(); ++i) {
      if (draft_.passable[i].spaces[0] == space || draft_.passable[i].spaces[1] == space) doors.push_back(i);
    }
    return doors;
  }

  // Removes it from the choices.
  std::size_t TakeLeastUsed(std::vector<std::size_t>& choices) {
    int least = draft_.passable[choices[0]].used;
    for (const std::size_t choice : choices) least = std::min(least, draft_.passable[choice].used);
    std::vector<std::size_t> equal;
    for (const std::size_t choice : choices) {
      if (draft_.passable[choice].used == least) equal.push_back(choice);
    }
    const std::size_t chosen = equal[static_cast<std::size_t>(noise_.Below(static_cast<int>(equal.size())))];
    std::erase(choices, chosen);
    return chosen;
  }

  // Through the door and to a point behind it, and notes the space there. False: furniture is in the way.
  bool GoThrough(const PassableDoor& passable, int& space, Robot& robot) {
    const Door& door = draft_.campus.doors[passable.door];
    const bool forward = passable.spaces[0] == space;
    const Eigen::Vector2d normal = forward ? passable.normal : Eigen::Vector2d(-passable.normal);
    const int behind_space = passable.spaces[forward ? 1 : 0];
    const double angle = noise_.Uniform(-0.6, 0.6);
    const std::optional<Eigen::Vector2d> goal = PointInside(behind_space);
    for (const double turn : {angle, angle / 2.0, 0.0}) {
      const Eigen::Vector2d along(std::cos(turn) * normal.x() - std::sin(turn) * normal.y(),
                                  std::sin(turn) * normal.x() + std::cos(turn) * normal.y());
      for (double way = 1.2; way >= 0.5; way -= 0.1) {
        const Eigen::Vector2d before = door.middle() - way * along;
        const Eigen::Vector2d behind = door.middle() + way * along;
        if (!ground_.IsFree(before, behind)) continue;
        const std::vector<Eigen::Vector2d> approach = Leg(space, robot.route.back().point, before);
        const std::vector<Eigen::Vector2d> leave =
            goal ? Leg(behind_space, behind, *goal) : std::vector<Eigen::Vector2d>();
        if (approach.empty() || leave.empty()) break;
        for (const Eigen::Vector2d& point : approach) robot.route.push_back(StepTo(point));
        robot.route.push_back(StepTo(behind));
        for (const Eigen::Vector2d& point : leave) robot.route.push_back(StepTo(point));
        space = behind_space;
        return true;
      }
    }
    return false;
  }

  std::vector<Eigen::Vector2d> Leg(int space, const Eigen::Vector2d& from, const Eigen::Vector2d& to) const {
    const Rect& rect = draft_.space(space);
    return ground_.Way(from, to, FreeGround::Box{{rect.x, rect.y}, {rect.x + rect.width, rect.y + rect.height}});
  }

  BuildingDraft& draft_;
  Noise noise_;
  const World world_;
  const FreeGround ground_;
};

}  // namespace

void AddSecondRobot(BuildingDraft& draft, std::uint64_t seed) {
  LatePlanner planner(draft, seed);
  Robot second = planner.SecondRobot();
  planner.AddWayBack(draft.campus.robots[0]);
  planner.AddWayBack(second);
  draft.campus.robots.push_back(std::move(second));
}

}  // namespace enfilade::simulator
