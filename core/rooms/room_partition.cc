// SPDX-License-Identifier: Apache-2.0
#include "core/rooms/room_partition.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "core/geometry/pose2.h"
#include "core/rooms/basins.h"
#include "core/rooms/distance_field.h"
#include "core/rooms/door_candidate.h"
#include "core/rooms/ground.h"
#include "core/rooms/region_graph.h"
#include "core/rooms/region_map.h"

namespace enfilade::rooms {
namespace {

constexpr std::size_t kMaxRooms = std::numeric_limits<std::uint16_t>::max();
constexpr double kPassed = -6.0;  // added to the openness of a door that a robot is known to have passed

struct JudgedLine {
  DoorCandidate line;
  double openness = 0.0;
};

Eigen::Vector2d ToCells(const grid::GridGeometry& geometry, const Eigen::Vector2d& p_map) {
  const Eigen::Vector2d p = Inverse(geometry.T_map_grid) * p_map;
  return p / geometry.resolution - Eigen::Vector2d(0.5, 0.5);
}

Eigen::Vector2d ToMap(const grid::GridGeometry& geometry, const Eigen::Vector2d& cells) {
  const Eigen::Vector2d p = (cells + Eigen::Vector2d(0.5, 0.5)) * geometry.resolution;
  return geometry.T_map_grid * p;
}

class Partitioner {
 public:
  Partitioner(const grid::OccupancyGrid& grid, const RoomOptions& options, const RoomEvidence& evidence)
      : geometry_(grid.geometry),
        options_(options),
        evidence_(evidence),
        ground_(ReadGround(grid, options, evidence.trajectory)),
        field_(DistancesToWalls(ground_)) {}

  RoomPartition Run() {
    FindLines();
    std::vector<DoorCandidate> lines;
    for (const JudgedLine& judged : lines_) lines.push_back(judged.line);
    cut_ = CutAlong(ground_, lines);
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
  double cells(double metres) const { return metres / geometry_.resolution; }

  void FindLines() {
    const NarrowPlaces limits{std::max(1.0, cells(options_.narrowing)), cells(options_.max_door) / 2.0};
    for (const std::size_t place : FindNarrowPlaces(ground_, field_, limits)) {
      const auto line = CandidateAt(ground_, field_, place, cells(options_.max_door) + 1.0);
      if (!line || line->length() - 1.0 < cells(options_.min_door)) continue;
      AddLine(*line);
    }
    for (const PassageHint& hint : evidence_.passages) AddHint(hint);
  }

  void AddLine(const DoorCandidate& line) {
    const double openness = OpennessOf(GatherEvidence(ground_, line));
    const double same = cells(0.15);
    for (JudgedLine& known : lines_) {
      const bool forward = (known.line.a - line.a).norm() < same && (known.line.b - line.b).norm() < same;
      const bool reverse = (known.line.a - line.b).norm() < same && (known.line.b - line.a).norm() < same;
      if (!forward && !reverse) continue;
      if (openness < known.openness) known = {line, openness};
      return;
    }
    lines_.push_back({line, openness});
  }

  // The nearest candidate that agrees with the hint is a door; without one, the hint's own line is.
  void AddHint(const PassageHint& hint) {
    const Eigen::Vector2d a = ToCells(geometry_, hint.a);
    const Eigen::Vector2d b = ToCells(geometry_, hint.b);
    if (!a.allFinite() || !b.allFinite() || (b - a).norm() < 1.0) return;
    const Eigen::Vector2d along = (b - a).normalized();
    JudgedLine* best = nullptr;
    double nearest = cells(0.6);
    for (JudgedLine& judged : lines_) {
      const double turn = std::abs((judged.line.b - judged.line.a).normalized().dot(along));
      const double distance = (judged.line.middle() - (a + b) / 2.0).norm();
      if (turn < 0.7 || distance >= nearest) continue;
      nearest = distance;
      best = &judged;
    }
    if (best == nullptr) {
      lines_.push_back({Extended(a, b), 0.0});
      best = &lines_.back();
    }
    if (best->line.passed) return;
    best->line.passed = true;
    best->openness = std::min(best->openness, 0.0) + kPassed;
  }

  // The line between two points, made longer until both ends are on walls, if these are near.
  DoorCandidate Extended(Eigen::Vector2d a, Eigen::Vector2d b) const {
    const Eigen::Vector2d along = (b - a).normalized();
    const auto extend = [&](const Eigen::Vector2d& end, const Eigen::Vector2d& direction) {
      for (double step = 0.0; step < cells(0.6); step += 1.0) {
        const Eigen::Vector2d p = end + step * direction;
        if (!ground_.IsOpen(static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y())))) return p;
      }
      return end;
    };
    return {extend(a, -along), extend(b, along), false};
  }

  void Cluster() {
    std::vector<RegionBorder> borders;
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      const Sides& sides = cut_.sides[i];
      if (sides.before < 0 || sides.behind < 0) continue;
      borders.push_back({sides.before, sides.behind, lines_[i].openness});
    }
    room_of_region_ = ClusterRegions(static_cast<int>(cut_.map.sizes.size()), borders);
  }

  // Joins rooms that are too small to be one to the neighbour that they are most open to, the smallest first.
  void AbsorbSmall() {
    const double least = options_.min_room / (geometry_.resolution * geometry_.resolution);
    while (true) {
      std::map<int, std::int64_t> sizes;
      for (std::size_t region = 0; region < room_of_region_.size(); ++region) {
        sizes[room_of_region_[region]] += cut_.map.sizes[region];
      }
      std::map<std::pair<int, int>, double> borders;
      for (std::size_t i = 0; i < lines_.size(); ++i) {
        const auto [one, other] = RoomsAt(i);
        if (one == other || one < 0 || other < 0) continue;
        borders[{one, other}] += lines_[i].openness;
        borders[{other, one}] += lines_[i].openness;
      }
      std::optional<std::pair<int, int>> best;
      for (const auto& [pair, openness] : borders) {
        if (static_cast<double>(sizes[pair.first]) >= least) continue;
        if (best &&
            (sizes[best->first] < sizes[pair.first] || (best->first == pair.first && borders[*best] >= openness))) {
          continue;
        }
        best = pair;
      }
      if (!best) return;
      for (int& room : room_of_region_) room = room == best->first ? best->second : room;
    }
  }

  std::pair<int, int> RoomsAt(std::size_t line) const {
    const auto room = [&](std::int32_t region) {
      return region < 0 ? -1 : room_of_region_[static_cast<std::size_t>(region)];
    };
    return {room(cut_.sides[line].before), room(cut_.sides[line].behind)};
  }

  void NumberRooms(RoomPartition& partition) {
    std::map<int, std::int64_t> sizes;
    for (std::size_t region = 0; region < room_of_region_.size(); ++region) {
      sizes[room_of_region_[region]] += cut_.map.sizes[region];
    }
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
      const auto width = static_cast<std::size_t>(geometry_.width);
      partition.rooms[id - 1U].centre =
          ToMap(geometry_, {static_cast<double>(i % width), static_cast<double>(i / width)});
    }
    for (const Eigen::Vector2d& p : evidence_.trajectory) {
      if (const int id = partition.RoomAt(p); id > 0) partition.rooms[static_cast<std::size_t>(id) - 1].entered = true;
    }
  }

  void AddDoors(RoomPartition& partition) const {
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      const auto [before, behind] = RoomsAt(i);
      if (before < 0 || behind < 0) continue;
      const int one = IdOf(before);
      const int other = IdOf(behind);
      if (one == other || one == 0 || other == 0) continue;
      const DoorCandidate& line = lines_[i].line;
      partition.doors.push_back(
          {ToMap(geometry_, line.a), ToMap(geometry_, line.b), {std::min(one, other), std::max(one, other)}});
    }
  }

  const grid::GridGeometry geometry_;
  const RoomOptions options_;
  const RoomEvidence evidence_;
  GroundMap ground_;
  DistanceField field_;
  std::vector<JudgedLine> lines_;
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

RoomPartition PartitionRooms(const grid::OccupancyGrid& grid, const RoomOptions& options,
                             const RoomEvidence& evidence) {
  return Partitioner(grid, options, evidence).Run();
}

}  // namespace enfilade::rooms
