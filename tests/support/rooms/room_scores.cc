// SPDX-License-Identifier: Apache-2.0
#include "tests/support/rooms/room_scores.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "fmt/format.h"
#include "fmt/ranges.h"

namespace enfilade::testing {
namespace {

constexpr double kLeastArea = 2.0;  // m^2
constexpr double kLeastIou = 0.7;
constexpr double kNearPassage = 1.0;  // m

// A change of the room along the drive.
struct RoomChange {
  Eigen::Vector2d p_map;
  std::size_t at;
  int from;
  int to;
};

std::vector<RoomChange> ChangesAlong(std::span<const DrivePoint> drive, std::span<const int> rooms) {
  std::vector<RoomChange> changes;
  for (std::size_t i = 1; i < drive.size(); ++i) {
    if (rooms[i] != rooms[i - 1]) changes.push_back({drive[i].p_map, i, rooms[i - 1], rooms[i]});
  }
  return changes;
}

// The room at each point; outside of all rooms, the one before.
std::vector<int> RoomsAlong(const rooms::RoomPartition& partition, std::span<const DrivePoint> drive) {
  std::vector<int> rooms;
  for (const DrivePoint& point : drive) {
    const int room = partition.RoomAt(point.p_map);
    rooms.push_back(room == 0 && !rooms.empty() ? rooms.back() : room);
  }
  return rooms;
}

}  // namespace

std::vector<int> RoomsOfTruth(const grid::OccupancyGrid& truth) {
  const auto free = [&](std::size_t cell) {
    return truth.cells[cell] != grid::kUnknownCell && grid::ProbabilityOfCell(truth.cells[cell]) < 0.25;
  };
  std::vector<int> pieces(truth.cells.size(), 0);
  int count = 0;
  const auto width = static_cast<std::size_t>(truth.geometry.width);
  std::vector<std::size_t> stack;
  for (std::size_t start = 0; start < pieces.size(); ++start) {
    if (pieces[start] != 0 || !free(start)) continue;
    const int piece = ++count;
    stack.assign(1, start);
    pieces[start] = piece;
    const auto visit = [&](std::size_t cell) {
      if (pieces[cell] != 0 || !free(cell)) return;
      pieces[cell] = piece;
      stack.push_back(cell);
    };
    while (!stack.empty()) {
      const std::size_t cell = stack.back();
      stack.pop_back();
      if (cell % width > 0) visit(cell - 1);
      if (cell % width + 1 < width) visit(cell + 1);
      if (cell >= width) visit(cell - width);
      if (cell + width < pieces.size()) visit(cell + width);
    }
  }
  return pieces;
}

PlanScore ScorePlan(const rooms::RoomPartition& partition, std::span<const int> truth) {
  std::map<std::pair<int, int>, std::int64_t> common;
  std::map<int, std::int64_t> sizes;
  std::vector<std::int64_t> segment_sizes(partition.rooms.size() + 1, 0);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    ++segment_sizes[partition.labels[i]];
    if (truth[i] > 0) ++sizes[truth[i]];
    if (truth[i] > 0 && partition.labels[i] > 0) ++common[{truth[i], partition.labels[i]}];
  }
  const double cell = partition.geometry.resolution * partition.geometry.resolution;
  PlanScore score;
  score.segments = static_cast<int>(partition.rooms.size());
  for (const auto& [room, size] : sizes) score.rooms += static_cast<double>(size) * cell > kLeastArea ? 1 : 0;
  // An overlap of more than half excludes a second one, so that no segment is used twice.
  for (const auto& [pair, cells] : common) {
    const std::int64_t size = sizes[pair.first];
    const std::int64_t together = size + segment_sizes[static_cast<std::size_t>(pair.second)] - cells;
    const bool found = static_cast<double>(cells) >= kLeastIou * static_cast<double>(together);
    if (found && static_cast<double>(size) * cell > kLeastArea) ++score.found;
  }
  return score;
}

DriveScore ScoreDrive(const rooms::RoomPartition& partition, std::span<const DrivePoint> drive,
                      std::span<const DrivePassage> passages) {
  DriveScore score;
  const std::vector<int> rooms = RoomsAlong(partition, drive);
  std::map<std::string, std::map<int, double>> travelled;  // in area and room, m
  for (std::size_t i = 1; i < drive.size(); ++i) {
    if (drive[i].area.empty() || drive[i].area != drive[i - 1].area) continue;
    const bool at_door = std::any_of(passages.begin(), passages.end(), [&](const DrivePassage& passage) {
      return (passage.p_map - drive[i].p_map).norm() < kNearPassage / 2.0;
    });
    if (!at_door) travelled[drive[i].area][rooms[i]] += (drive[i].p_map - drive[i - 1].p_map).norm();
  }
  constexpr double kShort = 0.5;  // m
  std::map<int, std::set<std::string>> areas_of_room;
  for (const auto& [area, in_room] : travelled) {
    std::vector<int> mine;
    for (const auto& [room, metres] : in_room) {
      if (metres >= kShort) mine.push_back(room);
    }
    if (mine.empty()) continue;
    ++score.areas;
    if (mine.size() > 1) {
      ++score.doubled;
      score.faults.push_back(fmt::format("{} has {} rooms", area, mine.size()));
    }
    for (const int room : mine) areas_of_room[room].insert(area);
  }
  score.rooms = static_cast<int>(areas_of_room.size());
  for (const auto& [room, areas] : areas_of_room) {
    if (areas.size() < 2) continue;
    score.merged += static_cast<int>(areas.size()) - 1;
    score.faults.push_back(fmt::format("room {} holds {}", room, fmt::join(areas, ", ")));
  }
  std::set<std::string> doors;
  std::vector<RoomChange> changes = ChangesAlong(drive, rooms);
  std::vector<bool> used(changes.size(), false);
  for (const DrivePassage& passage : passages) {
    doors.insert(passage.door);
    double nearest = kNearPassage;
    std::size_t best = changes.size();
    for (std::size_t i = 0; i < changes.size(); ++i) {
      const double distance = (changes[i].p_map - passage.p_map).norm();
      if (used[i] || distance >= nearest) continue;
      nearest = distance;
      best = i;
    }
    if (best < changes.size()) {
      used[best] = true;
      continue;
    }
    ++score.missed;
    score.faults.push_back(
        fmt::format("{} not seen at ({:.1f}, {:.1f})", passage.door, passage.p_map.x(), passage.p_map.y()));
  }
  score.doors = static_cast<int>(doors.size());
  for (std::size_t i = 0; i < changes.size(); ++i) {
    if (used[i] || changes[i].from == 0) continue;
    ++score.false_changes;
    score.faults.push_back(fmt::format("false change {} to {} at ({:.1f}, {:.1f})", changes[i].from, changes[i].to,
                                       changes[i].p_map.x(), changes[i].p_map.y()));
  }
  return score;
}

}  // namespace enfilade::testing
