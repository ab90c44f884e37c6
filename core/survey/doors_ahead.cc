// SPDX-License-Identifier: Apache-2.0
#include "core/survey/doors_ahead.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

#include "core/geometry/segments.h"
#include "core/rooms/room_options.h"

namespace enfilade::survey {
namespace {

// How far from the middle of a gap the ground beside it is looked for, m.
constexpr double kDepth = 0.3;
constexpr double kBeside = 1.0;
constexpr double kPost = 0.2;     // m: the line that closes the gap ends this far inside the posts
constexpr double kSealed = 0.75;  // cells, half the width of that line: steps from cell to cell do not cross it
constexpr double kDetour = 3.0;   // m from the gap: no farther away does a way round count

}  // namespace

bool DoorsAhead::MayBeUnknown(const Sighting& sighting) const {
  if (sighting.gap) {
    const Pose2 T_level_gap = sighting.T_level_robot * sighting.gap->T_place_gap;
    return !IsPassedDoor(T_level_gap) && !LeadsNowhere(T_level_gap, sighting.gap->width);
  }
  return !IsPassedDoorAhead(sighting.T_level_robot) && !IsOpenAhead(sighting.T_level_robot);
}

bool DoorsAhead::IsPassed(const rooms::Door& door) const {
  const Eigen::Vector2d middle = (door.a + door.b) / 2.0;
  return std::any_of(passed_.begin(), passed_.end(),
                     [&](const Pose2& place) { return (place.translation() - middle).norm() < options_.same_door; });
}

// Of the doors at the gap, one that robots went through is the nearest.
bool DoorsAhead::IsPassedDoor(const Pose2& T_level_gap) const {
  double nearest = options_.same_door;
  for (const Pose2& door : passed_) {
    nearest = std::min(nearest, (door.translation() - T_level_gap.translation()).norm());
  }
  if (nearest >= options_.same_door) return false;
  return std::none_of(partition_.doors.begin(), partition_.doors.end(), [&](const rooms::Door& door) {
    return !IsPassed(door) && ((door.a + door.b) / 2.0 - T_level_gap.translation()).norm() < nearest;
  });
}

// Both sides of the gap are known, and no unknown door parts them.
bool DoorsAhead::LeadsNowhere(const Pose2& T_level_gap, double width) const {
  const auto before = GroundBeside(T_level_gap, -1.0);
  const auto behind = GroundBeside(T_level_gap, 1.0);
  if (!before || !behind) return false;
  const int room = partition_.RoomAt(*before);
  const int other = partition_.RoomAt(*behind);
  // Where nothing joins two rooms, the gap is a nook before the wall between them.
  return room == other ? IsInsideRoom(T_level_gap, width, *before, *behind) : !IsJoinedAt(T_level_gap, room, other);
}

bool DoorsAhead::IsJoinedAt(const Pose2& T_level_gap, int room, int other) const {
  return std::any_of(partition_.doors.begin(), partition_.doors.end(), [&](const rooms::Door& door) {
    return std::minmax(door.rooms[0], door.rooms[1]) == std::minmax(room, other) &&
           ((door.a + door.b) / 2.0 - T_level_gap.translation()).norm() < options_.same_door;
  });
}

// What lies behind the gap, in the same room as what lies before it, is not just a glimpse of another one. A glimpse
// counts as ground of the room before the gap, too, but only the gap joins the two. Less than min_room is a nook; from
// small_room on, the partition has judged that there is no door.
bool DoorsAhead::IsInsideRoom(const Pose2& T_level_gap, double width, const Eigen::Vector2d& before,
                              const Eigen::Vector2d& behind) const {
  const int room = partition_.RoomAt(before);
  const double cell = partition_.geometry.resolution;
  const Eigen::Vector2d left = T_level_gap * Eigen::Vector2d(0.0, width / 2.0 + kPost);
  const Eigen::Vector2d right = T_level_gap * Eigen::Vector2d(0.0, -width / 2.0 - kPost);
  // Cells are counted from the ground behind the gap, along the axes of the partition's grid.
  const Pose2 T_level_start{behind.x(), behind.y(), partition_.geometry.T_map_grid.yaw};
  const auto is_open = [&](const std::array<int, 2>& at) {
    const Eigen::Vector2d place = T_level_start * Eigen::Vector2d(at[0] * cell, at[1] * cell);
    return (place - T_level_gap.translation()).norm() < kDetour && partition_.RoomAt(place) == room &&
           DistanceToSegment(place, left, right) > kSealed * cell;
  };
  const Eigen::Vector2d goal = Inverse(T_level_start) * before / cell;
  std::set<std::array<int, 2>> reached = {{0, 0}};
  std::vector<std::array<int, 2>> open = {{0, 0}};
  while (!open.empty()) {
    const std::array<int, 2> at = open.back();
    open.pop_back();
    if ((Eigen::Vector2d(at[0], at[1]) - goal).cwiseAbs().maxCoeff() < 1.0) return true;
    for (const auto& [x, y] : {std::array{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      const std::array<int, 2> next = {at[0] + x, at[1] + y};
      if (is_open(next) && reached.insert(next).second) open.push_back(next);
    }
  }
  const double area = static_cast<double>(reached.size()) * cell * cell;
  return area < rooms::RoomOptions().min_room || area >= rooms::RoomOptions().small_room;
}

// The nearest ground of a room before (`way` -1) or behind (1) the gap. Unset: there is none.
std::optional<Eigen::Vector2d> DoorsAhead::GroundBeside(const Pose2& T_level_gap, double way) const {
  const double step = partition_.geometry.resolution;
  for (double at = std::max(kDepth, step); at <= kBeside; at += step) {
    const Eigen::Vector2d place = T_level_gap * Eigen::Vector2d(way * at, 0.0);
    if (partition_.RoomAt(place) > 0) return place;
  }
  return std::nullopt;
}

// How far aside a place is from the way of a robot that saw a door there; unset if it was not ahead.
std::optional<double> DoorsAhead::AsideOf(const Eigen::Vector2d& place, const Pose2& T_level_robot) const {
  constexpr double kAngle = 0.5;  // m aside for each metre ahead
  const Eigen::Vector2d d = Inverse(T_level_robot) * place;
  const double aside = std::abs(d.y());
  if (d.x() <= -1.0 || d.x() >= options_.candidate_ahead) return std::nullopt;
  if (aside >= options_.candidate_across + kAngle * std::max(d.x(), 0.0)) return std::nullopt;
  return aside;
}

// Of the doors ahead, one that robots went through is the nearest to the robot's way.
bool DoorsAhead::IsPassedDoorAhead(const Pose2& T_level_robot) const {
  double passed = std::numeric_limits<double>::infinity();
  for (const Pose2& door : passed_) {
    passed = std::min(passed, AsideOf(door.translation(), T_level_robot).value_or(passed));
  }
  if (!std::isfinite(passed)) return false;
  return std::none_of(partition_.doors.begin(), partition_.doors.end(), [&](const rooms::Door& door) {
    return !IsPassed(door) && AsideOf((door.a + door.b) / 2.0, T_level_robot).value_or(passed) < passed;
  });
}

// Nothing but the room's own ground lies ahead: what looked like a door is none.
bool DoorsAhead::IsOpenAhead(const Pose2& T_level_robot) const {
  constexpr double kObstacle = 0.5;  // m
  const int room = partition_.RoomAt(T_level_robot.translation());
  if (room == 0) return false;
  const double step = partition_.geometry.resolution;
  double elsewhere = 0.0;  // m, without a break
  for (double ahead = step; ahead <= options_.candidate_ahead; ahead += step) {
    const bool here = partition_.RoomAt(T_level_robot * Eigen::Vector2d(ahead, 0.0)) == room;
    elsewhere = here ? 0.0 : elsewhere + step;
    if (elsewhere > kObstacle) return false;
  }
  return true;
}

}  // namespace enfilade::survey
