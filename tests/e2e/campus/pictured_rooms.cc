// SPDX-License-Identifier: Apache-2.0
#include "tests/e2e/campus/pictured_rooms.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>

#include "fmt/format.h"
#include "tests/support/rooms/coloured_rooms.h"

namespace enfilade::testing {
namespace {

constexpr double kLeastWay = 0.5;   // m
constexpr double kLeastArea = 2.0;  // m^2

class Picture {
 public:
  explicit Picture(const PicturedRooms& rooms) : rooms_(rooms) {
    absl::StatusOr<ColouredRooms> coloured = ReadColouredRooms(rooms.picture);
    if (!coloured.ok()) throw std::runtime_error(std::string(coloured.status().message()));
    coloured_ = *std::move(coloured);
    pixels_.resize(coloured_.colours.size());
    for (const int room : coloured_.rooms) ++pixels_[static_cast<std::size_t>(room)];
  }

  // Empty: in none.
  std::string RoomAt(const Eigen::Vector2d& p_map) const {
    const Eigen::Vector2d p = Inverse(rooms_.T_map_picture) * p_map / rooms_.resolution;
    const int x = static_cast<int>(std::floor(p.x()));
    const int y = static_cast<int>(std::floor(p.y()));
    if (!coloured_.geometry.contains(x, y)) return "";
    const auto room = static_cast<std::size_t>(coloured_.rooms[coloured_.geometry.index(x, y)]);
    const double area = static_cast<double>(pixels_[room]) * rooms_.resolution * rooms_.resolution;
    if (room == 0 || area < kLeastArea) return "";
    const auto& colour = coloured_.colours[room];
    return fmt::format("#{:02x}{:02x}{:02x}", colour[0], colour[1], colour[2]);
  }

 private:
  const PicturedRooms& rooms_;
  ColouredRooms coloured_;
  std::vector<std::int64_t> pixels_;  // of each room
};

}  // namespace

DriveTruth RoomsEntered(const std::string& robot, const std::vector<TimedPose>& trajectory,
                        const PicturedRooms& rooms) {
  const Picture picture(rooms);
  DriveTruth truth;
  truth.robot = robot;
  std::vector<std::string> seen;  // the room at each pose; outside of all rooms, the one before
  for (const TimedPose& point : trajectory) {
    const auto time = static_cast<TimeNs>(std::llround(point.time * 1e9));
    truth.poses.push_back({time, point.pose, "", ""});
    const std::string room = picture.RoomAt(point.pose.translation());
    seen.push_back(room.empty() && !seen.empty() ? seen.back() : room);
  }
  std::string last;
  for (std::size_t begin = 0; begin < seen.size();) {
    double way = 0.0;
    std::size_t end = begin + 1;
    for (; end < seen.size() && seen[end] == seen[begin]; ++end) {
      way += (trajectory[end].pose.translation() - trajectory[end - 1].pose.translation()).norm();
    }
    if (last.empty()) {
      last = seen[begin];
    } else if (seen[begin] != last && way >= kLeastWay) {
      const std::string door = std::min(last, seen[begin]) + std::max(last, seen[begin]);
      truth.passages.push_back(
          {truth.poses[begin].time, truth.poses[begin].T_campus_robot, "", door, last, seen[begin]});
      last = seen[begin];
    }
    for (; begin < end; ++begin) truth.poses[begin].area = last;
  }
  return truth;
}

}  // namespace enfilade::testing
