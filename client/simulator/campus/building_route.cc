// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <optional>

#include "client/simulator/campus/building_draft.h"

namespace enfilade::simulator {
namespace {

class RoutePlanner {
 public:
  explicit RoutePlanner(BuildingDraft& draft) : draft_(draft), noise_(draft.noise), campus_(draft.campus) {}

  void Run() {
    Robot robot;
    robot.id = "robot";
    robot.level = "ground";
    campus_.robots.push_back(robot);
    std::vector<PassableDoor>& doors = draft_.passable;
    int space =
        doors.empty() ? 0 : doors[static_cast<std::size_t>(noise_.Below(static_cast<int>(doors.size())))].spaces[0];
    Go(PointInside(space));
    for (int i = 0; i < draft_.options.passages; ++i) {
      PassableDoor* const chosen = ChooseDoor(space);
      if (!chosen) break;
      ++chosen->used;
      GoThrough(*chosen, space);
      space = chosen->spaces[0] == space ? chosen->spaces[1] : chosen->spaces[0];
      Go(PointInside(space));
    }
    if (draft_.route().size() < 2) Go(PointInside(space));
  }

 private:
  // One of the least used doors of `space`; nullptr if it has none.
  PassableDoor* ChooseDoor(int space) {
    std::vector<PassableDoor*> choices;
    for (PassableDoor& door : draft_.passable) {
      if (door.spaces[0] != space && door.spaces[1] != space) continue;
      if (!PointBeside(door, door.spaces[0], 0.0) || !PointBeside(door, door.spaces[1], 0.0)) continue;
      choices.push_back(&door);
    }
    if (choices.empty()) return nullptr;
    int least = choices[0]->used;
    for (const PassableDoor* choice : choices) least = std::min(least, choice->used);
    std::erase_if(choices, [&](const PassableDoor* choice) { return choice->used > least; });
    return choices[static_cast<std::size_t>(noise_.Below(static_cast<int>(choices.size())))];
  }

  // A point before the door on the side of `space`, from which the way through is `angle` off the normal: as far away
  // as the space allows.
  std::optional<Eigen::Vector2d> PointBeside(const PassableDoor& passable, int space, double angle) const {
    const Door& door = campus_.doors[passable.door];
    const Eigen::Vector2d away = passable.spaces[0] == space ? Eigen::Vector2d(-passable.normal) : passable.normal;
    const Eigen::Vector2d ray(std::cos(angle) * away.x() - std::sin(angle) * away.y(),
                              std::sin(angle) * away.x() + std::cos(angle) * away.y());
    for (double way = 1.6; way >= 0.6; way -= 0.1) {
      const Eigen::Vector2d point = door.middle() + way * ray;
      if (draft_.space(space).Holds(point, 0.4)) return point;
    }
    return std::nullopt;
  }

  void Go(const Eigen::Vector2d& point) {
    RouteStep step;
    step.point = point;
    campus_.robots.back().route.push_back(step);
  }

  // From `space` through the door, at an angle at which the robot fits between the jambs.
  void GoThrough(const PassableDoor& passable, int space) {
    const BuildingOptions& options = draft_.options;
    const Door& door = campus_.doors[passable.door];
    const int other = passable.spaces[0] == space ? passable.spaces[1] : passable.spaces[0];
    double angle = noise_.Uniform(-options.max_incidence, options.max_incidence);
    while (door.width() * std::cos(angle) - campus_.wall_thickness * std::sin(std::abs(angle)) <
               2.0 * options.robot_half_width + 0.1 &&
           std::abs(angle) > 0.05) {
      angle *= 0.8;
    }
    if (door.leaf) angle *= 0.3;
    for (int attempt = 0; attempt < 12; ++attempt, angle *= 0.75) {
      const auto before = PointBeside(passable, space, angle);
      const auto behind = PointBeside(passable, other, angle);
      if (!before || !behind) continue;
      Go(*before);
      Go(*behind);
      return;
    }
    Go(*PointBeside(passable, space, 0.0));
    Go(*PointBeside(passable, other, 0.0));
  }

  Eigen::Vector2d PointInside(int space) {
    const Rect& rect = draft_.space(space);
    const double margin = std::min({1.0, rect.width / 2.0 - 0.2, rect.height / 2.0 - 0.2});
    double width = rect.width;
    if (rect.width > 24.0) width = 12.0;  // only the near part of the yard
    return {noise_.Uniform(rect.x + margin, rect.x + width - margin),
            noise_.Uniform(rect.y + margin, rect.y + rect.height - margin)};
  }

  BuildingDraft& draft_;
  Noise& noise_;
  Campus& campus_;
};

}  // namespace

void PlanRoute(BuildingDraft& draft) { RoutePlanner(draft).Run(); }

}  // namespace enfilade::simulator
