// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/rooms/true_plans.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "absl/status/status.h"
#include "core/base/status_macros.h"
#include "core/geometry/pose2.h"
#include "core/grid/distance_field.h"
#include "core/grid/files/plan_image.h"
#include "io/file.h"
#include "tests/support/rooms/coloured_rooms.h"
#include "tests/support/rooms/room_scores.h"

namespace enfilade::bench {
namespace {

const std::string kColoured = "gt_colored_";
const std::string kRobotsMap = "robot:";

absl::StatusOr<grid::OccupancyGrid> ReadPlanFile(const std::filesystem::path& path) {
  ENFILADE_ASSIGN_OR_RETURN(const std::string bytes, io::ReadFile(path));
  return grid::ReadPlan(bytes);
}

// The map from which the truth was drawn, in the truth's frame.
grid::OccupancyGrid TurnedInto(const grid::GridGeometry& geometry, const grid::OccupancyGrid& map) {
  constexpr double kTurn = 20.0 * kDegree;
  grid::OccupancyGrid turned{geometry, std::vector<std::uint8_t>(geometry.cell_count(), grid::kUnknownCell)};
  const Eigen::Vector2d middle = Eigen::Vector2d(geometry.width - 1, geometry.height - 1) / 2.0;
  const Eigen::Vector2d map_middle = Eigen::Vector2d(map.geometry.width - 1, map.geometry.height - 1) / 2.0;
  const Eigen::Rotation2Dd to_map(kTurn);
  for (int row = 0; row < geometry.height; ++row) {
    for (int column = 0; column < geometry.width; ++column) {
      const Eigen::Vector2d p = map_middle + to_map * (Eigen::Vector2d(column, row) - middle);
      const int x = static_cast<int>(std::lround(p.x()));
      const int y = static_cast<int>(std::lround(p.y()));
      if (map.geometry.contains(x, y)) turned.cells[geometry.index(column, row)] = map.cells[map.geometry.index(x, y)];
    }
  }
  return turned;
}

// The two rooms that a line one cell wide parts at (column, row), the lower first; {0, 0}: it is no such cell.
std::pair<int, int> PartedAt(const TruePlan& plan, int column, int row) {
  const auto room = [&](int x, int y) {
    return plan.map.geometry.contains(x, y) ? plan.rooms[plan.map.geometry.index(x, y)] : 0;
  };
  if (room(column, row) != 0) return {0, 0};
  for (const auto& [dx, dy] : {std::pair(1, 0), std::pair(0, 1)}) {
    const auto rooms = std::minmax({room(column - dx, row - dy), room(column + dx, row + dy)});
    if (rooms.first != 0 && rooms.first != rooms.second) return rooms;
  }
  return {0, 0};
}

// The cells of the lines that close doors.
std::vector<std::size_t> ClosedDoors(const TruePlan& plan) {
  constexpr double kNarrowest = 0.5;  // m
  constexpr double kWidest = 2.5;     // m
  const grid::GridGeometry& geometry = plan.map.geometry;
  std::map<std::pair<int, int>, std::pair<int, int>> lines;  // row and column; the rooms
  for (int row = 0; row < geometry.height; ++row) {
    for (int column = 0; column < geometry.width; ++column) {
      const std::pair<int, int> rooms = PartedAt(plan, column, row);
      if (rooms.first != 0) lines[{row, column}] = rooms;
    }
  }
  std::vector<std::size_t> closed;
  while (!lines.empty()) {
    const std::pair<int, int> rooms = lines.begin()->second;
    std::vector<std::pair<int, int>> stretch{lines.begin()->first};
    lines.erase(lines.begin());
    for (std::size_t next = 0; next < stretch.size(); ++next) {
      const auto [row, column] = stretch[next];
      for (int y = row - 1; y <= row + 1; ++y) {
        for (int x = column - 1; x <= column + 1; ++x) {
          const auto found = lines.find({y, x});
          if (found == lines.end() || found->second != rooms) continue;
          stretch.push_back(found->first);
          lines.erase(found);
        }
      }
    }
    const double length = static_cast<double>(stretch.size()) * geometry.resolution;
    if (length < kNarrowest || length > kWidest) continue;
    for (const auto& [row, column] : stretch) closed.push_back(geometry.index(column, row));
  }
  return closed;
}

// A robot's map of the rooms' ground.
grid::OccupancyGrid MapOf(const TruePlan& plan) {
  constexpr double kSeen = 0.15;  // m into a wall
  const grid::GridGeometry& geometry = plan.map.geometry;
  std::vector<std::uint8_t> free(geometry.cell_count());
  for (std::size_t i = 0; i < free.size(); ++i) free[i] = plan.rooms[i] != 0 ? 1 : 0;
  for (const std::size_t cell : ClosedDoors(plan)) free[cell] = 1;
  const grid::DistanceField field = grid::DistancesTo(free, geometry.width, geometry.height);
  grid::OccupancyGrid map{geometry, std::vector<std::uint8_t>(free.size(), grid::kUnknownCell)};
  for (std::size_t i = 0; i < free.size(); ++i) {
    if (static_cast<double>(field.distance[i]) * geometry.resolution > kSeen) continue;
    map.cells[i] = grid::CellFromProbability(free[i] != 0 ? 0.0 : 1.0);
  }
  return map;
}

}  // namespace

absl::StatusOr<std::vector<TruePlan>> ReadTruePlans(const std::filesystem::path& folder, const std::string& kind) {
  const std::string suffix = "_gt_segmentation.png";
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name.ends_with(suffix)) names.push_back(name.substr(0, name.size() - suffix.size()));
  }
  std::sort(names.begin(), names.end());
  std::vector<TruePlan> plans;
  for (const std::string& name : names) {
    ENFILADE_ASSIGN_OR_RETURN(grid::OccupancyGrid map, ReadPlanFile(folder / (name + kind + ".png")));
    ENFILADE_ASSIGN_OR_RETURN(const grid::OccupancyGrid truth, ReadPlanFile(folder / (name + suffix)));
    plans.push_back({name + kind, std::move(map), testing::RoomsOfTruth(truth)});
  }
  return plans;
}

absl::StatusOr<TruePlan> ReadColouredPlan(const std::filesystem::path& truth) {
  if (!truth.filename().string().starts_with(kColoured)) {
    return absl::InvalidArgumentError(truth.string() + " is not named " + kColoured + "NAME.png");
  }
  ENFILADE_ASSIGN_OR_RETURN(testing::ColouredRooms coloured, testing::ReadColouredRooms(truth));
  TruePlan plan;
  plan.name = kRobotsMap + truth.stem().string().substr(kColoured.size());
  plan.map.geometry = coloured.geometry;
  plan.rooms = std::move(coloured.rooms);
  const std::filesystem::path drawn_from =
      truth.parent_path() / ("incremental_" + plan.name.substr(kRobotsMap.size()) + ".png");
  if (std::filesystem::exists(drawn_from)) {
    ENFILADE_ASSIGN_OR_RETURN(const grid::OccupancyGrid map, ReadPlanFile(drawn_from));
    plan.map = TurnedInto(plan.map.geometry, map);
  } else {
    plan.map = MapOf(plan);
  }
  return plan;
}

}  // namespace enfilade::bench
