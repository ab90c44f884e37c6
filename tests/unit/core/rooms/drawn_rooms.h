// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/grid/occupancy_grid.h"

namespace enfilade::rooms {

// A map drawn as text, the top row first: '#' wall, ' ' and letters free, '?' unknown. A character is a square with
// sides of 0.25 m, `kCellsPerCharacter` cells of 5 cm.
class DrawnRooms {
 public:
  static constexpr int kCellsPerCharacter = 5;

  explicit DrawnRooms(std::vector<std::string> rows) : rows_(std::move(rows)) {
    grid.geometry.resolution = 0.05;
    for (const std::string& row : rows_) {
      grid.geometry.width = std::max(grid.geometry.width, static_cast<int>(row.size()) * kCellsPerCharacter);
    }
    grid.geometry.height = static_cast<int>(rows_.size()) * kCellsPerCharacter;
    grid.cells.resize(grid.geometry.cell_count());
    for (int row = 0; row < grid.geometry.height; ++row) {
      for (int column = 0; column < grid.geometry.width; ++column) {
        grid.cells[grid.geometry.index(column, row)] = CellOf(CharacterAt(column, row));
      }
    }
  }

  // The middle of the square with this letter.
  Eigen::Vector2d operator[](char letter) const {
    const double side = grid.geometry.resolution * kCellsPerCharacter;
    for (std::size_t row = 0; row < rows_.size(); ++row) {
      const std::size_t column = rows_[row].find(letter);
      if (column == std::string::npos) continue;
      return {(static_cast<double>(column) + 0.5) * side, (static_cast<double>(rows_.size() - 1 - row) + 0.5) * side};
    }
    return Eigen::Vector2d::Constant(-1.0);
  }

  // From letter to letter, with a point each 0.3 m.
  std::vector<Eigen::Vector2d> Path(std::string_view letters) const {
    std::vector<Eigen::Vector2d> path;
    for (const char letter : letters) {
      const Eigen::Vector2d to = (*this)[letter];
      const Eigen::Vector2d from = path.empty() ? to : path.back();
      const int steps = std::max(1, static_cast<int>((to - from).norm() / 0.3));
      for (int k = 1; k <= steps; ++k) path.push_back(from + (to - from) * k / steps);
    }
    return path;
  }

  grid::OccupancyGrid grid;

 private:
  char CharacterAt(int column, int row) const {
    const std::string& line = rows_[rows_.size() - 1 - static_cast<std::size_t>(row / kCellsPerCharacter)];
    const auto at = static_cast<std::size_t>(column / kCellsPerCharacter);
    return at < line.size() ? line[at] : '?';
  }

  static std::uint8_t CellOf(char character) {
    if (character == '?') return grid::kUnknownCell;
    return grid::CellFromProbability(character == '#' ? 0.9 : 0.1);
  }

  std::vector<std::string> rows_;
};

}  // namespace enfilade::rooms
