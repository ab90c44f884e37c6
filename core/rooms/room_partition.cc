// SPDX-License-Identifier: Apache-2.0
#include "core/rooms/room_partition.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "core/geometry/pose2.h"
#include "core/rooms/door_candidate.h"
#include "core/rooms/door_lines.h"
#include "core/rooms/door_odds.h"
#include "core/rooms/ground.h"
#include "core/rooms/passage_silence.h"
#include "core/rooms/region_graph.h"
#include "core/rooms/region_map.h"
#include "core/rooms/surroundings.h"

namespace enfilade::rooms {
namespace {

constexpr std::size_t kMaxRooms = std::numeric_limits<std::uint16_t>::max();

class Partitioner {
 public:
  Partitioner(const grid::OccupancyGrid& grid, const RoomOptions& options, const RoomEvidence& evidence)
      : geometry_(grid.geometry),
        options_(options),
        evidence_(evidence),
        odds_(evidence),
        ground_(ReadGround(grid, options, evidence.trajectory)),
        field_(DistancesToWalls(ground_)) {}

  RoomPartition Run() {
    lines_ = FindDoorLines(ground_, field_, options_, odds_);
    AddNarrowsOnPath(ground_, geometry_, evidence_.trajectory, options_, odds_, lines_);
    AddPassages(ground_, geometry_, evidence_.passages, options_, odds_, lines_);
    WeighSilence(geometry_, evidence_, odds_, lines_);
    std::vector<DoorCandidate> lines;
    for (const DoorLine& line : lines_) lines.push_back(line.line);
    cut_ = CutAlong(ground_, field_, lines);
    LookAround();
    Cluster();
    AbsorbSmall();
    RoomPartition partition;
    partition.geometry = geometry_;
    NumberRooms(partition);
    DescribeRooms(partition);
    AddDoors(partition);
    return partition;
  }

 private:
  // Judges the lines again by what is around them.
  void LookAround() {
    const std::vector<Surroundings> sides = SurroundingsOf(ground_, cut_, lines_);
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      lines_[i].openness = odds_.OpennessOf(ValuesOf(lines_[i], sides[i]));
    }
  }

  void Cluster() {
    std::vector<RegionBorder> borders;
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      const Sides& sides = cut_.sides[i];
      if (sides.before < 0 || sides.behind < 0) continue;
      borders.push_back({sides.before, sides.behind, JoinWeight(lines_[i], options_.robot_radius)});
    }
    room_of_region_ = ClusterRegions(static_cast<int>(cut_.map.sizes.size()), borders);
  }

  // Joins rooms that are too small to be one to the neighbour that they are most open to, the smallest first.
  void AbsorbSmall() {
    const std::set<std::int32_t> entered = EnteredRegions();
    while (true) {
      const std::map<int, std::int64_t> sizes = SizesOfRooms();
      const std::set<int> small = TooSmall(sizes, entered);
      std::map<std::pair<int, int>, double> borders;
      for (std::size_t i = 0; i < lines_.size(); ++i) {
        const auto [one, other] = RoomsAt(i);
        if (one == other || one < 0 || other < 0) continue;
        borders[{one, other}] += JoinWeight(lines_[i], options_.robot_radius);
        borders[{other, one}] += JoinWeight(lines_[i], options_.robot_radius);
      }
      std::optional<std::pair<int, int>> best;
      for (const auto& [pair, openness] : borders) {
        if (!small.contains(pair.first)) continue;
        if (best && (sizes.at(best->first) < sizes.at(pair.first) ||
                     (best->first == pair.first && borders[*best] >= openness))) {
          continue;
        }
        best = pair;
      }
      if (!best) return;
      for (int& room : room_of_region_) room = room == best->first ? best->second : room;
    }
  }

  std::map<int, std::int64_t> SizesOfRooms() const {
    std::map<int, std::int64_t> sizes;
    for (std::size_t region = 0; region < room_of_region_.size(); ++region) {
      sizes[room_of_region_[region]] += cut_.map.sizes[region];
    }
    return sizes;
  }

  // The rooms of less than `min_room`, and those of less than `small_room` that no robot has entered or fits into.
  std::set<int> TooSmall(const std::map<int, std::int64_t>& sizes,
                         const std::set<std::int32_t>& entered_regions) const {
    const double cell_area = geometry_.resolution * geometry_.resolution;
    std::set<int> entered;
    for (const std::int32_t region : entered_regions) entered.insert(room_of_region_[static_cast<std::size_t>(region)]);
    std::set<int> small;
    std::map<int, std::vector<std::size_t>> cells;  // of the rooms that may be narrow
    for (const auto& [room, size] : sizes) {
      const double area = static_cast<double>(size) * cell_area;
      if (area < options_.min_room || (area < options_.small_room && !entered.contains(room))) {
        small.insert(room);
      } else if (area < options_.small_room) {
        cells[room];
      }
    }
    if (cells.empty()) return small;
    for (std::size_t cell = 0; cell < cut_.map.region.size(); ++cell) {
      const std::int32_t region = cut_.map.region[cell];
      if (region < 0) continue;
      const auto found = cells.find(room_of_region_[static_cast<std::size_t>(region)]);
      if (found != cells.end()) found->second.push_back(cell);
    }
    for (const auto& [room, own] : cells) {
      if (InscribedRadius(own, geometry_.width) * geometry_.resolution < options_.robot_radius) small.insert(room);
    }
    return small;
  }

  std::set<std::int32_t> EnteredRegions() const {
    std::set<std::int32_t> entered;
    for (const Eigen::Vector2d& p_map : evidence_.trajectory) {
      const Eigen::Vector2d p = ToCells(geometry_, p_map);
      const int x = Rounded(p.x());
      const int y = Rounded(p.y());
      if (ground_.contains(x, y)) entered.insert(cut_.map.region[ground_.index(x, y)]);
    }
    entered.erase(RegionMap::kNone);
    return entered;
  }

  std::pair<int, int> RoomsAt(std::size_t line) const {
    const auto room = [&](std::int32_t region) {
      return region < 0 ? -1 : room_of_region_[static_cast<std::size_t>(region)];
    };
    return {room(cut_.sides[line].before), room(cut_.sides[line].behind)};
  }

  void NumberRooms(RoomPartition& partition) {
    const std::map<int, std::int64_t> sizes = SizesOfRooms();
    const double cell_area = geometry_.resolution * geometry_.resolution;
    std::vector<std::pair<std::int64_t, int>> order;
    for (const auto& [room, size] : sizes) {
      if (static_cast<double>(size) * cell_area >= options_.min_room) order.emplace_back(-size, room);
    }
    std::sort(order.begin(), order.end());
    order.resize(std::min(order.size(), kMaxRooms));
    for (const auto& [minus_size, room] : order) {
      const int id = static_cast<int>(partition.rooms.size()) + 1;
      id_of_room_[room] = id;
      partition.rooms.push_back({id, static_cast<double>(-minus_size) * cell_area, {}, false});
    }
    partition.labels.assign(cut_.map.region.size(), 0);
    for (std::size_t i = 0; i < partition.labels.size(); ++i) {
      const std::int32_t region = cut_.map.region[i];
      if (region >= 0)
        partition.labels[i] = static_cast<std::uint16_t>(IdOf(room_of_region_[static_cast<std::size_t>(region)]));
    }
  }

  int IdOf(int room) const {
    const auto found = id_of_room_.find(room);
    return found == id_of_room_.end() ? 0 : found->second;
  }

  void DescribeRooms(RoomPartition& partition) const {
    std::vector<float> widest(partition.rooms.size() + 1, -1.0F);
    for (std::size_t i = 0; i < partition.labels.size(); ++i) {
      const std::uint16_t id = partition.labels[i];
      if (id == 0 || field_.distance[i] <= widest[id]) continue;
      widest[id] = field_.distance[i];
      partition.rooms[id - 1U].centre = ToMap(geometry_, ground_.CentreOf(i));
    }
    for (const Eigen::Vector2d& p : evidence_.trajectory) {
      if (const int id = partition.RoomAt(p); id > 0) partition.rooms[static_cast<std::size_t>(id) - 1].entered = true;
    }
  }

  // The lines between two rooms. Of several lines across one opening only the clearest is a door.
  void AddDoors(RoomPartition& partition) const {
    std::vector<std::size_t> order(lines_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t one, std::size_t other) { return lines_[one].openness < lines_[other].openness; });
    for (const std::size_t i : order) {
      const auto [before, behind] = RoomsAt(i);
      if (before < 0 || behind < 0) continue;
      const std::array<int, 2> rooms{std::min(IdOf(before), IdOf(behind)), std::max(IdOf(before), IdOf(behind))};
      if (rooms[0] == rooms[1] || rooms[0] == 0) continue;
      const DoorCandidate& line = lines_[i].line;
      const Door door{ToMap(geometry_, line.a), ToMap(geometry_, line.b), rooms};
      const bool known = std::any_of(partition.doors.begin(), partition.doors.end(), [&](const Door& other) {
        const double apart = ((door.a + door.b) / 2.0 - (other.a + other.b) / 2.0).norm();
        return other.rooms == rooms && apart < std::max(door.width(), other.width()) / 2.0;
      });
      if (!known) partition.doors.push_back(door);
    }
  }

  const grid::GridGeometry geometry_;
  const RoomOptions options_;
  const RoomEvidence evidence_;
  const DoorOdds odds_;
  GroundMap ground_;
  DistanceField field_;
  std::vector<DoorLine> lines_;
  CutGround cut_;
  std::vector<int> room_of_region_;
  std::map<int, int> id_of_room_;
};

}  // namespace

int RoomPartition::RoomAt(const Eigen::Vector2d& p_map) const {
  const Eigen::Vector2d p = Inverse(geometry.T_map_grid) * p_map / geometry.resolution;
  if (!(p.x() >= 0.0 && p.y() >= 0.0 && p.x() < geometry.width && p.y() < geometry.height)) return 0;
  return labels[geometry.index(static_cast<int>(p.x()), static_cast<int>(p.y()))];
}

PassageHint PassageThrough(const Pose2& T_map_door, double width) {
  constexpr double kUsualDoor = 1.0;  // m
  const double half = (width > 0.0 ? width : kUsualDoor) / 2.0;
  return {T_map_door * Eigen::Vector2d(0.0, half), T_map_door * Eigen::Vector2d(0.0, -half)};
}

RoomPartition PartitionRooms(const grid::OccupancyGrid& grid, const RoomOptions& options,
                             const RoomEvidence& evidence) {
  return Partitioner(grid, options, evidence).Run();
}

}  // namespace enfilade::rooms
