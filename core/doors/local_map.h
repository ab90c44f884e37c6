// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/base/binary.h"
#include "core/geometry/pose2.h"
#include "core/sensor/laser_scan.h"

namespace enfilade::doors {

// A straight line, here one that is taken as closed: a door's, or a wall's.
struct Line {
  Eigen::Vector2d a = Eigen::Vector2d::Zero();
  Eigen::Vector2d b = Eigen::Vector2d::Zero();
};

struct Disc {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  double radius = 0.0;  // m
};

// What the last scans have seen around the robot: a square of cells in the odometry frame that moves with the robot.
// Each cell counts hits against beams that passed through it, within small bounds, so that a person who walks on is
// forgotten after a few scans.
class LocalMap {
 public:
  // The size of a cell, and the length up to which beams are used, m.
  LocalMap(double cell, double reach);

  void Add(const sensor::LaserScan& scan, const Pose2& T_odom_robot);

  bool IsOccupied(int column, int row) const { return At(column, row) >= kOccupied; }
  bool IsFree(int column, int row) const { return At(column, row) < 0; }
  // Cells are counted from the odometry frame's origin.
  int CellOf(double coordinate) const { return static_cast<int>(std::floor(coordinate / cell_)); }
  Eigen::Vector2d MiddleOf(int column, int row) const { return {(column + 0.5) * cell_, (row + 0.5) * cell_}; }
  double cell() const { return cell_; }

  // The middles of occupied cells with a free neighbour, within `radius` of a point.
  std::vector<Eigen::Vector2d> SurfaceWithin(const Eigen::Vector2d& point, double radius) const;

  // Whether observed free cells within the disc join the two points if the line is closed.
  bool AreJoined(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Line& closed, const Disc& within) const;

  void Write(BinaryWriter& writer) const;
  // False if the state is of a map of another size.
  bool Read(BinaryReader& reader);

 private:
  static constexpr std::int8_t kOccupied = 2;
  static constexpr std::int8_t kMost = 9;
  static constexpr std::int8_t kLeast = -6;
  static constexpr std::int8_t kHit = 3;

  std::int8_t At(int column, int row) const {
    column -= column0_;
    row -= row0_;
    if (column < 0 || row < 0 || column >= side_ || row >= side_) return 0;
    return cells_[static_cast<std::size_t>(row) * static_cast<std::size_t>(side_) + static_cast<std::size_t>(column)];
  }
  void MoveTo(const Eigen::Vector2d& point);
  void Clear(const Eigen::Vector2d& from, const Eigen::Vector2d& to);

  double cell_;
  double reach_;
  int side_;  // cells
  int column0_ = 0;
  int row0_ = 0;
  bool placed_ = false;
  std::vector<std::int8_t> cells_;
  std::vector<std::uint32_t> touched_;  // by which scan, so that one scan counts once
  std::uint32_t scan_ = 0;
};

}  // namespace enfilade::doors
