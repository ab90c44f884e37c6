// SPDX-License-Identifier: Apache-2.0
#include "core/edit/apply.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/grid/occupancy_values.h"

namespace enfilade::edit {
namespace {

using grid::GreyCells;
using grid::GreyInterpretation;
using grid::kTileSize;
using grid::MapMode;
using grid::MapRaster;

constexpr std::array kSayable = {Instruction::kUnknown, Instruction::kFree, Instruction::kOccupied};

std::string_view WordOf(Instruction instruction) {
  return instruction == Instruction::kUnknown ? "unknown" : (instruction == Instruction::kFree ? "free" : "occupied");
}

// As in ROS: 0 free, 100 occupied.
std::int8_t ValueOf(Instruction instruction) {
  if (instruction == Instruction::kUnknown) return grid::kUnknownValue;
  return instruction == Instruction::kFree ? std::int8_t{0} : std::int8_t{100};
}

// The grey that reads back as `wanted`; the usual one for it, or the nearest to that.
std::optional<grid::GreyAlpha> GreyOf(const GreyCells& cells, bool has_alpha, std::int8_t wanted) {
  const GreyInterpretation& by = cells.interpretation;
  grid::GreySaveOptions usual;
  usual.mode = by.mode;
  int start = grid::SavedGrey(usual, wanted).grey;
  if (by.negate && by.mode != MapMode::kRaw) start = 255 - start;
  start = std::min(start, cells.max_value);
  const std::array<std::int8_t, 256> values = grid::LoadedValues(by, cells.max_value);
  const auto reads_as_wanted = [&](int grey) {
    if (grey < 0 || grey > cells.max_value) return false;
    return (has_alpha ? grid::LoadedValue(by, grey, grid::kOpaqueAlpha) : values[static_cast<std::size_t>(grey)]) ==
           wanted;
  };
  for (int distance = 0; distance <= 255; ++distance) {
    for (const int grey : {start - distance, start + distance}) {
      if (reads_as_wanted(grey)) return grid::GreyAlpha{static_cast<std::uint8_t>(grey), grid::kOpaqueAlpha};
    }
  }
  if (has_alpha && grid::LoadedValue(by, start, 0) == wanted)
    return grid::GreyAlpha{static_cast<std::uint8_t>(start), 0};
  return std::nullopt;
}

absl::Status CannotSay(Instruction instruction, std::string_view form) {
  return FailedPrecondition("the map was imported as {}, in which no value reads back as {}: edit it as {}", form,
                            WordOf(instruction),
                            instruction == Instruction::kUnknown ? "free or occupied" : "another value");
}

absl::Status CheckForm(const MapRaster& raster, bool has_alpha, Instruction instruction) {
  if (instruction == Instruction::kNone || instruction == Instruction::kClear) return absl::OkStatus();
  if (const auto* const grey = std::get_if<GreyCells>(&raster.cells)) {
    if (GreyOf(*grey, has_alpha, ValueOf(instruction))) return absl::OkStatus();
    constexpr std::array kModes = {"an image in mode trinary", "an image in mode scale", "an image in mode raw"};
    return CannotSay(instruction, kModes[static_cast<std::size_t>(grey->interpretation.mode)]);
  }
  if (std::holds_alternative<grid::UnitCells>(raster.cells) && instruction == Instruction::kUnknown) {
    return CannotSay(instruction, "JSON");
  }
  return absl::OkStatus();
}

// Writes each instruction's value where `write(place in the raster, instruction)` is called for.
template <typename Write>
void ForEachCell(const Overlay& overlay, grid::CellIndex min, const grid::GridGeometry& geometry, Write write) {
  for (const auto& [index, cells] : overlay.tiles()) {
    const std::int64_t left = std::int64_t{index.column} * kTileSize - min.column;
    const std::int64_t bottom = std::int64_t{index.row} * kTileSize - min.row;
    const int first = static_cast<int>(std::clamp<std::int64_t>(-left, 0, kTileSize));
    const int end = static_cast<int>(std::clamp<std::int64_t>(geometry.width - left, 0, kTileSize));
    for (int y = 0; y < kTileSize; ++y) {
      const std::int64_t row = bottom + y;
      if (row < 0 || row >= geometry.height) continue;
      for (int x = first; x < end; ++x) {
        const auto instruction = static_cast<Instruction>(cells[static_cast<std::size_t>(y * kTileSize + x)]);
        if (instruction == Instruction::kNone) continue;
        write(geometry.index(static_cast<int>(left) + x, static_cast<int>(row)), instruction);
      }
    }
  }
}

std::array<bool, 5> InstructionsIn(const Overlay& overlay, grid::CellIndex min, const grid::GridGeometry& geometry) {
  std::array<bool, 5> used{};
  ForEachCell(overlay, min, geometry,
              [&](std::size_t, Instruction instruction) { used[static_cast<std::size_t>(instruction)] = true; });
  return used;
}

}  // namespace

Lattice LatticeOf(const grid::RasterHeader& header) {
  const grid::GridGeometry& geometry = header.raster.geometry;
  if (header.lattice_min == grid::CellIndex{}) return {geometry.resolution, geometry.T_map_grid};
  return {geometry.resolution, {}};  // that of the map's frame; exactly, whatever the sum of cells was rounded to
}

CellBox BoxOf(const grid::RasterHeader& header) {
  const grid::GridGeometry& geometry = header.raster.geometry;
  return {header.lattice_min.column, header.lattice_min.row, geometry.width, geometry.height};
}

absl::Status CanSay(const grid::RasterHeader& header, Instruction instruction) {
  return CheckForm(header.raster, header.has_alpha, instruction);
}

absl::Status Apply(const Overlay& overlay, grid::CellIndex min, MapRaster& raster) {
  const std::array<bool, 5> used = InstructionsIn(overlay, min, raster.geometry);
  const auto* const image = std::get_if<GreyCells>(&raster.cells);
  const bool has_alpha = image != nullptr && !image->alpha.empty();
  for (const Instruction instruction : kSayable) {
    if (used[static_cast<std::size_t>(instruction)])
      ENFILADE_RETURN_IF_ERROR(CheckForm(raster, has_alpha, instruction));
  }
  if (auto* const grid = std::get_if<grid::OccupancyCells>(&raster.cells)) {
    ForEachCell(overlay, min, raster.geometry, [&](std::size_t place, Instruction instruction) {
      grid->values[place] = grid::CellFromOccupancyValue(ValueOf(instruction));
    });
  } else if (auto* const unit = std::get_if<grid::UnitCells>(&raster.cells)) {
    ForEachCell(overlay, min, raster.geometry, [&](std::size_t place, Instruction instruction) {
      unit->values[place] = instruction == Instruction::kOccupied ? 1.0 : 0.0;
    });
  } else {
    auto& grey = std::get<GreyCells>(raster.cells);
    std::array<grid::GreyAlpha, 5> values{};
    for (const Instruction instruction : kSayable) {
      values[static_cast<std::size_t>(instruction)] =
          GreyOf(grey, has_alpha, ValueOf(instruction)).value_or(grid::GreyAlpha{});
    }
    ForEachCell(overlay, min, raster.geometry, [&](std::size_t place, Instruction instruction) {
      const grid::GreyAlpha& value = values[static_cast<std::size_t>(instruction)];
      grey.grey[place] = value.grey;
      if (!grey.alpha.empty()) grey.alpha[place] = value.alpha;
    });
  }
  return absl::OkStatus();
}

std::vector<grid::CellClass> ClassesOf(const MapRaster& raster) {
  const std::array<grid::CellClass, 256> classes = grid::ClassesOfCells();
  const grid::OccupancyGrid grid = grid::ToOccupancyGrid(raster);
  std::vector<grid::CellClass> result(grid.cells.size());
  std::transform(grid.cells.begin(), grid.cells.end(), result.begin(),
                 [&](std::uint8_t cell) { return classes[cell]; });
  return result;
}

}  // namespace enfilade::edit
