// SPDX-License-Identifier: Apache-2.0
#include "core/grid/files/plan_image.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/status_macros.h"
#include "core/grid/files/grey_image.h"
#include "core/grid/files/pgm_codec.h"
#include "core/grid/map_raster.h"

namespace enfilade::grid {
namespace {

constexpr int kLeastFree = 240;            // of 255
constexpr int kLeastUnknown = 100;         // darker greys are walls, however many
constexpr std::size_t kUnknownShare = 20;  // unknown fills at least 1 / 20 of the picture

struct GreyPlan {
  int width = 0;
  int height = 0;
  GreyCells cells;
};

absl::StatusOr<GreyPlan> ReadGreyPlan(std::string_view bytes) {
  if (bytes.starts_with("P2") || bytes.starts_with("P5")) {
    ENFILADE_ASSIGN_OR_RETURN(PgmImage image, DecodePgm(bytes));
    GreyCells cells;
    cells.max_value = image.max_value;
    cells.grey = std::move(image.pixels);
    return GreyPlan{image.width, image.height, std::move(cells)};
  }
  ENFILADE_ASSIGN_OR_RETURN(GreyImage image, DecodeGreyPng(bytes, MapDialect::kNav2));
  return GreyPlan{image.width, image.height, std::move(image.cells)};
}

// The cell of each grey level.
std::array<std::uint8_t, 256> PlanCells(const GreyCells& cells) {
  std::array<std::size_t, 256> count{};
  for (const std::uint8_t grey : cells.grey) ++count[grey];
  std::array<std::uint8_t, 256> values{};
  for (int level = 0; level < 256; ++level) {
    const int grey = level * 255 / cells.max_value;
    const bool fills = count[static_cast<std::size_t>(level)] * kUnknownShare >= cells.grey.size();
    std::uint8_t& value = values[static_cast<std::size_t>(level)];
    value = CellFromProbability(grey >= kLeastFree ? 0.0 : 1.0);
    if (grey >= kLeastUnknown && grey < kLeastFree && fills) value = kUnknownCell;
  }
  return values;
}

}  // namespace

absl::StatusOr<OccupancyGrid> ReadPlan(std::string_view bytes) {
  ENFILADE_ASSIGN_OR_RETURN(const GreyPlan plan, ReadGreyPlan(bytes));
  OccupancyGrid grid;
  grid.geometry.width = plan.width;
  grid.geometry.height = plan.height;
  grid.cells.resize(plan.cells.grey.size());
  const std::array<std::uint8_t, 256> values = PlanCells(plan.cells);
  for (std::size_t i = 0; i < grid.cells.size(); ++i) {
    const bool clear = !plan.cells.alpha.empty() && plan.cells.alpha[i] < 128;
    grid.cells[i] = clear ? kUnknownCell : values[plan.cells.grey[i]];
  }
  return grid;
}

}  // namespace enfilade::grid
