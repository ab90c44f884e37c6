// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/core/edit/edited_maps.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/edit/apply.h"

namespace enfilade::edit {
namespace {

using grid::GreyCells;
using grid::GreyInterpretation;
using grid::MapRaster;

const grid::GridGeometry kSmall{0.05, {1.0, -2.0, 0.0}, 23, 17};

std::vector<std::uint8_t> RandomBytes(std::mt19937& random, int most) {
  std::vector<std::uint8_t> bytes(kSmall.cell_count());
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random() % (static_cast<std::uint32_t>(most) + 1));
  return bytes;
}

// Whether both have the same bytes in a cell.
bool HaveSameCell(const MapRaster& a, const MapRaster& b, std::size_t place) {
  if (const auto* const grey = std::get_if<GreyCells>(&a.cells)) {
    const auto& other = std::get<GreyCells>(b.cells);
    return grey->grey[place] == other.grey[place] && (grey->alpha.empty() || grey->alpha[place] == other.alpha[place]);
  }
  if (const auto* const unit = std::get_if<grid::UnitCells>(&a.cells)) {
    return unit->values[place] == std::get<grid::UnitCells>(b.cells).values[place];
  }
  return std::get<grid::OccupancyCells>(a.cells).values[place] == std::get<grid::OccupancyCells>(b.cells).values[place];
}

void AddImages(const GreyInterpretation& by, std::mt19937& random, std::vector<MapRaster>& forms) {
  for (const int max_value : {255, 254, 200, 100, 15, 1}) {
    forms.push_back({kSmall, GreyCells{.grey = RandomBytes(random, max_value),
                                       .max_value = max_value,
                                       .interpretation = by,
                                       .pgm_header = "P5 #x\n23 17 ",
                                       .pgm_trailer = "end"}});
  }
  forms.push_back(
      {kSmall, GreyCells{.grey = RandomBytes(random, 255), .alpha = RandomBytes(random, 255), .interpretation = by}});
}

}  // namespace

std::vector<MapRaster> EveryForm(std::mt19937& random) {
  std::vector<MapRaster> forms;
  for (const auto mode : {grid::MapMode::kTrinary, grid::MapMode::kScale, grid::MapMode::kRaw}) {
    for (const auto dialect : {grid::MapDialect::kNav2, grid::MapDialect::kRos1}) {
      for (const bool negate : {false, true}) {
        // The usual ones, Nav2's own 0.25, equal ones, ones that leave no grey for a class, and swapped ones.
        for (const auto& [free, occupied] :
             {std::pair{0.196, 0.65}, {0.25, 0.65}, {0.5, 0.5}, {0.0, 1.0}, {-0.1, 1.1}, {0.8, 0.3}}) {
          AddImages({mode, dialect, negate, occupied, free}, random, forms);
        }
      }
    }
  }
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<double> values(kSmall.cell_count());
  for (double& value : values) value = unit(random);
  forms.push_back({kSmall, grid::UnitCells{values, {1.0, 2.1, -2.0, -1.2, 0.05, 0.05, 10.0}}});
  forms.push_back({kSmall, grid::OccupancyCells{RandomBytes(random, 255)}});
  return forms;
}

std::string NameOf(const MapRaster& form) {
  const auto* const grey = std::get_if<GreyCells>(&form.cells);
  if (grey == nullptr) return std::holds_alternative<grid::UnitCells>(form.cells) ? "JSON" : "our own";
  const GreyInterpretation& by = grey->interpretation;
  return fmt::format("{} in mode {} of dialect {}, negate {}, {} and {}, white {}",
                     grey->alpha.empty() ? "grey" : "alpha", static_cast<int>(by.mode), static_cast<int>(by.dialect),
                     by.negate, by.free_thresh, by.occupied_thresh, grey->max_value);
}

void ExpectExactlyApplied(const MapRaster& before, const MapRaster& after, const Overlay& overlay,
                          grid::CellIndex min) {
  ASSERT_EQ(after.geometry, before.geometry);
  ASSERT_EQ(after.cells.index(), before.cells.index());
  const grid::OccupancyGrid shown = grid::ToOccupancyGrid(after);
  std::int64_t other = 0;
  std::int64_t wrong = 0;
  for (int row = 0; row < before.geometry.height; ++row) {
    for (int column = 0; column < before.geometry.width; ++column) {
      const std::size_t place = before.geometry.index(column, row);
      const std::uint8_t cell = shown.cells[place];
      switch (overlay.At(min.column + column, min.row + row)) {
        case Instruction::kUnknown:
          wrong += cell == grid::kUnknownCell ? 0 : 1;
          break;
        case Instruction::kFree:
          wrong += cell == grid::CellFromProbability(0.0) ? 0 : 1;
          break;
        case Instruction::kOccupied:
          wrong += cell == grid::CellFromProbability(1.0) ? 0 : 1;
          break;
        default:
          other += HaveSameCell(before, after, place) ? 0 : 1;
      }
    }
  }
  EXPECT_EQ(wrong, 0) << "edited cells of " << NameOf(before) << " do not read back";
  EXPECT_EQ(other, 0) << "cells of " << NameOf(before) << " changed that nobody has edited";
}

}  // namespace enfilade::edit
