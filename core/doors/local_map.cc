// SPDX-License-Identifier: Apache-2.0
#include "core/doors/local_map.h"

#include <algorithm>
#include <cstdlib>

namespace enfilade::doors {

LocalMap::LocalMap(double cell, double reach)
    : cell_(cell), reach_(reach), side_(2 * static_cast<int>(std::ceil((reach + 2.0) / cell))) {
  cells_.assign(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_), 0);
  touched_.assign(cells_.size(), 0);
}

void LocalMap::MoveTo(const Eigen::Vector2d& point) {
  const int column0 = CellOf(point.x()) - side_ / 2;
  const int row0 = CellOf(point.y()) - side_ / 2;
  const int slack = static_cast<int>(1.0 / cell_);
  if (placed_ && std::abs(column0 - column0_) < slack && std::abs(row0 - row0_) < slack) return;
  std::vector<std::int8_t> moved(cells_.size(), 0);
  for (int row = 0; placed_ && row < side_; ++row) {
    for (int column = 0; column < side_; ++column) {
      moved[static_cast<std::size_t>(row) * static_cast<std::size_t>(side_) + static_cast<std::size_t>(column)] =
          At(column + column0, row + row0);
    }
  }
  cells_ = std::move(moved);
  std::fill(touched_.begin(), touched_.end(), 0);
  column0_ = column0;
  row0_ = row0;
  placed_ = true;
}

// Amanatides, Woo 1987. The last cell is not changed.
void LocalMap::Clear(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  const Eigen::Vector2d way = to - from;
  const double length = way.norm();
  int cell[2] = {CellOf(from.x()), CellOf(from.y())};
  const int last[2] = {CellOf(to.x()), CellOf(to.y())};
  int step[2];
  double next[2];
  double every[2];
  for (int axis = 0; axis < 2; ++axis) {
    step[axis] = way[axis] > 0.0 ? 1 : -1;
    const bool moves = way[axis] != 0.0;
    every[axis] = moves ? cell_ * length / std::abs(way[axis]) : 1e300;
    const double border = cell_ * (cell[axis] + (step[axis] > 0 ? 1 : 0));
    next[axis] = moves ? (border - from[axis]) * length / way[axis] : 1e300;
  }
  while (cell[0] != last[0] || cell[1] != last[1]) {
    const int column = cell[0] - column0_;
    const int row = cell[1] - row0_;
    if (column < 0 || row < 0 || column >= side_ || row >= side_) return;
    const std::size_t index =
        static_cast<std::size_t>(row) * static_cast<std::size_t>(side_) + static_cast<std::size_t>(column);
    if (touched_[index] != scan_) {
      touched_[index] = scan_;
      if (cells_[index] > kLeast) --cells_[index];
    }
    const int axis = next[0] < next[1] ? 0 : 1;
    if (next[axis] > length) return;
    cell[axis] += step[axis];
    next[axis] += every[axis];
  }
}

void LocalMap::Add(const sensor::LaserScan& scan, const Pose2& T_odom_robot) {
  MoveTo(T_odom_robot.translation());
  ++scan_;
  const Pose2 T_odom_laser = T_odom_robot * scan.T_robot_laser;
  const Eigen::Vector2d from = T_odom_laser.translation();
  const auto end_of = [&](std::size_t beam, double range) {
    const double bearing = T_odom_laser.yaw + scan.angle(beam);
    return Eigen::Vector2d(from + range * Eigen::Vector2d(std::cos(bearing), std::sin(bearing)));
  };
  // Hits first: no other beam of this scan clears their cells.
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    if (sensor::ClassifyBeam(scan, scan.ranges[i]) != sensor::BeamKind::kHit || scan.ranges[i] > reach_) continue;
    const Eigen::Vector2d end = end_of(i, static_cast<double>(scan.ranges[i]));
    const int column = CellOf(end.x()) - column0_;
    const int row = CellOf(end.y()) - row0_;
    if (column < 0 || row < 0 || column >= side_ || row >= side_) continue;
    const std::size_t index =
        static_cast<std::size_t>(row) * static_cast<std::size_t>(side_) + static_cast<std::size_t>(column);
    if (touched_[index] == scan_) continue;
    touched_[index] = scan_;
    cells_[index] = static_cast<std::int8_t>(std::min<int>(kMost, cells_[index] + kHit));
  }
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const sensor::BeamKind kind = sensor::ClassifyBeam(scan, scan.ranges[i]);
    if (kind == sensor::BeamKind::kUnknown) continue;
    const double range = kind == sensor::BeamKind::kHit ? std::min<double>(scan.ranges[i], reach_)
                                                        : std::min<double>(scan.range_max, reach_);
    Clear(from, end_of(i, range));
  }
}

std::vector<Eigen::Vector2d> LocalMap::SurfaceWithin(const Eigen::Vector2d& point, double radius) const {
  std::vector<Eigen::Vector2d> surface;
  const int reach = static_cast<int>(radius / cell_);
  const int column = CellOf(point.x());
  const int row = CellOf(point.y());
  for (int r = row - reach; r <= row + reach; ++r) {
    for (int c = column - reach; c <= column + reach; ++c) {
      if (!IsOccupied(c, r)) continue;
      if (!IsFree(c - 1, r) && !IsFree(c + 1, r) && !IsFree(c, r - 1) && !IsFree(c, r + 1)) continue;
      const Eigen::Vector2d middle = MiddleOf(c, r);
      if ((middle - point).squaredNorm() <= radius * radius) surface.push_back(middle);
    }
  }
  return surface;
}

bool LocalMap::AreJoined(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Line& closed,
                         const Disc& within) const {
  const auto& [a, b] = closed;
  const auto& [middle, radius] = within;
  const int reach = static_cast<int>(radius / cell_);
  const int side = 2 * reach + 1;
  const int column0 = CellOf(middle.x()) - reach;
  const int row0 = CellOf(middle.y()) - reach;
  enum : std::uint8_t { kClosed, kOpen, kReached };
  std::vector<std::uint8_t> cells(static_cast<std::size_t>(side) * static_cast<std::size_t>(side), kClosed);
  const auto index = [&](int c, int r) {
    return static_cast<std::size_t>(r) * static_cast<std::size_t>(side) + static_cast<std::size_t>(c);
  };
  const Eigen::Vector2d edge = b - a;
  for (int r = 0; r < side; ++r) {
    for (int c = 0; c < side; ++c) {
      const Eigen::Vector2d at = MiddleOf(c + column0, r + row0);
      if ((at - middle).norm() > radius || !IsFree(c + column0, r + row0)) continue;
      const double t = std::clamp((at - a).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
      if ((at - a - t * edge).norm() < 1.5 * cell_) continue;
      cells[index(c, r)] = kOpen;
    }
  }
  std::vector<std::pair<int, int>> stack = {{CellOf(from.x()) - column0, CellOf(from.y()) - row0}};
  const std::pair<int, int> goal{CellOf(to.x()) - column0, CellOf(to.y()) - row0};
  while (!stack.empty()) {
    const auto [c, r] = stack.back();
    stack.pop_back();
    if (std::abs(c - goal.first) <= 1 && std::abs(r - goal.second) <= 1) return true;
    for (const auto& [dc, dr] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      const int nc = c + dc;
      const int nr = r + dr;
      if (nc < 0 || nr < 0 || nc >= side || nr >= side || cells[index(nc, nr)] != kOpen) continue;
      cells[index(nc, nr)] = kReached;
      stack.emplace_back(nc, nr);
    }
  }
  return false;
}

void LocalMap::Write(BinaryWriter& writer) const {
  writer.Put<std::int32_t>(side_);
  writer.Put<std::int32_t>(column0_);
  writer.Put<std::int32_t>(row0_);
  writer.Put<std::uint8_t>(placed_);
  // Runs of equal cells: most are unknown.
  for (std::size_t i = 0; i < cells_.size();) {
    std::size_t end = i + 1;
    while (end < cells_.size() && cells_[end] == cells_[i] && end - i < 65535) ++end;
    writer.Put(static_cast<std::uint16_t>(end - i));
    writer.Put(cells_[i]);
    i = end;
  }
}

bool LocalMap::Read(BinaryReader& reader) {
  const bool fits = reader.Get<std::int32_t>() == side_;
  column0_ = reader.Get<std::int32_t>();
  row0_ = reader.Get<std::int32_t>();
  placed_ = reader.Get<std::uint8_t>() != 0;
  for (std::size_t i = 0; fits && i < cells_.size();) {
    const std::size_t count = reader.Get<std::uint16_t>();
    const auto value = reader.Get<std::int8_t>();
    if (!reader.ok() || count == 0 || i + count > cells_.size()) return false;
    std::fill_n(cells_.begin() + static_cast<std::ptrdiff_t>(i), count, value);
    i += count;
  }
  return fits && reader.ok();
}

}  // namespace enfilade::doors
