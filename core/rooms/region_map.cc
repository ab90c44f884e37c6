// SPDX-License-Identifier: Apache-2.0
#include "core/rooms/region_map.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace enfilade::rooms {
namespace {

constexpr std::int32_t kUnvisited = -2;
constexpr std::int32_t kOnLine = -3;

void Flood(const GroundMap& ground, RegionMap& map) {
  std::vector<std::size_t> stack;
  for (std::size_t start = 0; start < map.region.size(); ++start) {
    if (map.region[start] != kUnvisited) continue;
    const auto region = static_cast<std::int32_t>(map.sizes.size());
    map.sizes.push_back(0);
    stack.assign(1, start);
    map.region[start] = region;
    while (!stack.empty()) {
      const std::size_t cell = stack.back();
      stack.pop_back();
      ++map.sizes.back();
      ground.VisitSides(cell, [&](std::size_t neighbour) {
        if (map.region[neighbour] != kUnvisited) return;
        map.region[neighbour] = region;
        stack.push_back(neighbour);
      });
    }
  }
}

// The region met most often a few cells beside the line.
std::int32_t RegionBeside(const GroundMap& ground, const RegionMap& map, const DoorCandidate& line, double sign) {
  const Eigen::Vector2d along = (line.b - line.a).normalized();
  const Eigen::Vector2d aside = sign * Eigen::Vector2d(-along.y(), along.x());
  std::map<std::int32_t, int> votes;
  const int steps = static_cast<int>(line.length());
  for (int i = 1; i < steps; ++i) {
    for (const double offset : {2.0, 3.0}) {
      const Eigen::Vector2d p = line.a + i * along + offset * aside;
      const auto x = Rounded(p.x());
      const auto y = Rounded(p.y());
      if (!ground.IsOpen(x, y)) continue;
      const std::int32_t region = map.region[ground.index(x, y)];
      if (region >= 0) ++votes[region];
    }
  }
  std::int32_t best = RegionMap::kNone;
  int most = 0;
  for (const auto& [region, count] : votes) {
    if (count <= most) continue;
    most = count;
    best = region;
  }
  return best;
}

// Gives the cells on lines to the regions beside them, ring by ring.
void FillLines(const GroundMap& ground, std::vector<std::size_t> cells, RegionMap& map) {
  while (!cells.empty()) {
    std::vector<std::pair<std::size_t, std::int32_t>> filled;
    std::vector<std::size_t> left;
    for (const std::size_t cell : cells) {
      std::int32_t region = RegionMap::kNone;
      ground.VisitSides(cell, [&](std::size_t neighbour) {
        if (region < 0 && map.region[neighbour] >= 0) region = map.region[neighbour];
      });
      if (region >= 0) {
        filled.emplace_back(cell, region);
      } else {
        left.push_back(cell);
      }
    }
    if (filled.empty()) break;
    for (const auto& [cell, region] : filled) {
      map.region[cell] = region;
      ++map.sizes[static_cast<std::size_t>(region)];
    }
    cells = std::move(left);
  }
  for (std::int32_t& region : map.region) region = std::max(region, RegionMap::kNone);
}

}  // namespace

CutGround CutAlong(const GroundMap& ground, const DistanceField& field, std::span<const DoorCandidate> lines) {
  constexpr float kBesideWall = 1.5F;  // cells
  CutGround cut;
  cut.map.region.resize(ground.cells.size());
  for (std::size_t i = 0; i < ground.cells.size(); ++i) {
    cut.map.region[i] = ground.IsOpen(i) ? kUnvisited : RegionMap::kNone;
  }
  // Clutter is filled in the end: two lines may meet at a post.
  std::vector<std::size_t> on_lines;
  for (std::size_t i = 0; i < ground.cells.size(); ++i) {
    const bool beside_wall = ground.IsOpen(i) && field.distance[i] < kBesideWall;
    if (ground.cells[i] != Ground::kClutter && !beside_wall) continue;
    cut.map.region[i] = kOnLine;
    on_lines.push_back(i);
  }
  for (const DoorCandidate& line : lines) {
    VisitLineCells(ground, line, [&](std::size_t cell) {
      if (cut.map.region[cell] == kOnLine) return;
      cut.map.region[cell] = kOnLine;
      on_lines.push_back(cell);
    });
  }
  Flood(ground, cut.map);
  for (const DoorCandidate& line : lines) {
    cut.sides.push_back({RegionBeside(ground, cut.map, line, 1.0), RegionBeside(ground, cut.map, line, -1.0)});
  }
  FillLines(ground, std::move(on_lines), cut.map);
  return cut;
}

double InscribedRadius(std::span<const std::size_t> cells, int width) {
  if (cells.empty()) return 0.0;
  const auto column_of = [&](std::size_t cell) { return static_cast<int>(cell) % width; };
  const auto row_of = [&](std::size_t cell) { return static_cast<int>(cell) / width; };
  int left = column_of(cells.front()), right = left, bottom = row_of(cells.front()), top = bottom;
  for (const std::size_t cell : cells) {
    left = std::min(left, column_of(cell));
    right = std::max(right, column_of(cell));
    bottom = std::min(bottom, row_of(cell));
    top = std::max(top, row_of(cell));
  }
  // With a margin of one cell.
  const int columns = right - left + 3;
  const int rows = top - bottom + 3;
  std::vector<std::uint8_t> others(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), 1);
  for (const std::size_t cell : cells) {
    const int at = (row_of(cell) - bottom + 1) * columns + column_of(cell) - left + 1;
    others[static_cast<std::size_t>(at)] = 0;
  }
  const DistanceField field = grid::DistancesTo(others, columns, rows);
  return static_cast<double>(*std::max_element(field.distance.begin(), field.distance.end())) - 0.5;
}

}  // namespace enfilade::rooms
