// SPDX-License-Identifier: Apache-2.0
#include "core/areas/area_mask.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/areas/rasterize_area.h"
#include "core/base/error.h"

namespace enfilade::areas {
namespace {

constexpr int kMaxValue = 100;
// Limits are typed by people: what is this near to a multiple, relative to the multiplier, is one.
constexpr double kSameMultiple = 1e-6;

class MaskCells {
 public:
  MaskCells(const grid::GridGeometry& geometry, std::uint8_t everywhere)
      : geometry_(geometry), grey_(geometry.cell_count(), everywhere) {}

  // fill(first, end) changes cells of one row.
  template <typename FillSpan>
  void Change(const MapArea& area, AreaCells cells, const FillSpan& fill) {
    RasterizeArea(area.outline, geometry_, cells, [&](int row, int first_column, int last_column) {
      const auto begin = grey_.begin() + static_cast<std::ptrdiff_t>(geometry_.index(first_column, row));
      fill(begin, begin + (last_column - first_column + 1));
    });
  }
  grid::MapRaster Finish() && {
    grid::GreyCells cells{.grey = std::move(grey_)};
    cells.interpretation.mode = grid::MapMode::kRaw;
    return {geometry_, std::move(cells)};
  }

 private:
  const grid::GridGeometry geometry_;
  std::vector<std::uint8_t> grey_;
};

// The value that says a limit: the whole multiple of `multiplier` at or below it.
int ValueOf(double limit, double multiplier) {
  return static_cast<int>(std::floor(limit / multiplier + kSameMultiple));
}

bool IsMultiple(double limit, double multiplier) {
  return std::abs(limit / multiplier - std::round(limit / multiplier)) <= kSameMultiple;
}

double MultiplierFor(const std::vector<const MapArea*>& limits) {
  if (limits.empty()) return 1.0;
  double highest = 0.0;
  for (const MapArea* area : limits) highest = std::max(highest, area->speed_limit_mps);
  for (int value = 1; value <= kMaxValue; ++value) {
    const double multiplier = highest / value;
    const auto fits = [&](const MapArea* area) { return IsMultiple(area->speed_limit_mps, multiplier); };
    if (std::all_of(limits.begin(), limits.end(), fits)) return multiplier;
  }
  return highest / kMaxValue;
}

}  // namespace

grid::MapRaster KeepOutMask(const std::vector<MapArea>& areas, const grid::GridGeometry& geometry) {
  const auto is = [](AreaKind kind) { return [kind](const MapArea& area) { return area.kind == kind; }; };
  const bool prefers = std::any_of(areas.begin(), areas.end(), is(AreaKind::kPreferred));
  MaskCells cells(geometry, prefers ? kCostBesidePreferred : kPreferredCost);
  const auto fill_with = [](std::uint8_t value) {
    return [value](auto begin, auto end) { std::fill(begin, end, value); };
  };
  for (const MapArea& area : areas) {
    if (area.kind == AreaKind::kPreferred) cells.Change(area, AreaCells::kInside, fill_with(kPreferredCost));
  }
  for (const MapArea& area : areas) {
    if (area.kind == AreaKind::kKeepOut) cells.Change(area, AreaCells::kEntered, fill_with(kLethal));
  }
  return std::move(cells).Finish();
}

absl::StatusOr<SpeedMask> MakeSpeedMask(const std::vector<MapArea>& areas, const grid::GridGeometry& geometry) {
  std::vector<const MapArea*> limits;
  for (const MapArea& area : areas) {
    if (area.kind == AreaKind::kSpeedLimit) limits.push_back(&area);
  }
  SpeedMask mask;
  mask.multiplier = MultiplierFor(limits);
  MaskCells cells(geometry, 0);
  for (const MapArea* area : limits) {
    const int value = ValueOf(area->speed_limit_mps, mask.multiplier);
    if (value < 1) {
      return FailedPrecondition(
          "area \"{}\" has the limit {} m/s, below a hundredth of the map's highest limit ({} m/s): a mask has 100 "
          "speeds; raise the one or lower the other",
          area->display_name, area->speed_limit_mps, mask.multiplier * kMaxValue);
    }
    if (!IsMultiple(area->speed_limit_mps, mask.multiplier)) {
      mask.rounded.push_back({area->display_name, area->speed_limit_mps, value * mask.multiplier});
    }
    cells.Change(*area, AreaCells::kEntered, [value](auto begin, auto end) {
      for (auto cell = begin; cell != end; ++cell) {
        if (*cell == 0 || *cell > value) *cell = static_cast<std::uint8_t>(value);
      }
    });
  }
  mask.raster = std::move(cells).Finish();
  return mask;
}

}  // namespace enfilade::areas
