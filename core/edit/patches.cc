// SPDX-License-Identifier: Apache-2.0
#include "core/edit/patches.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/edit/integers.h"
#include "core/edit/spans.h"

namespace enfilade::edit {
namespace {

using grid::kTileSize;

// Of boxes of any numbers.
CellBox Intersection(const CellBox& a, const CellBox& b) {
  const auto overlap = [](std::int64_t first_a, int size_a, std::int64_t first_b, int size_b) {
    const std::int64_t first = std::max(first_a, first_b);
    return std::pair(static_cast<int>(first),
                     static_cast<int>(std::max<std::int64_t>(0, std::min(first_a + size_a, first_b + size_b) - first)));
  };
  const auto [column, width] = overlap(a.first_column, a.width, b.first_column, b.width);
  const auto [row, height] = overlap(a.first_row, a.height, b.first_row, b.height);
  return {column, row, width, height};
}

// Takes cells in the order of a patch.
class PatchWriter {
 public:
  explicit PatchWriter(const CellBox& box) { patch_.box = box; }

  void Take(int column, int row) {
    const std::int64_t at =
        std::int64_t{row - patch_.box.first_row} * patch_.box.width + (column - patch_.box.first_column);
    if (patch_.runs.empty() || at != end_) {
      LeaveOut(at - end_);
      patch_.runs.push_back(0);
    }
    ++patch_.runs.back();
    end_ = at + 1;
  }
  Patch Finish() && { return std::move(patch_); }

 private:
  void LeaveOut(std::int64_t cells) {
    constexpr std::int64_t kLongest = std::numeric_limits<std::uint32_t>::max();
    for (; cells > kLongest; cells -= kLongest) {
      patch_.runs.insert(patch_.runs.end(), {static_cast<std::uint32_t>(kLongest), 0U});
    }
    patch_.runs.push_back(static_cast<std::uint32_t>(cells));
  }

  Patch patch_;
  std::int64_t end_ = 0;  // of the cells that are settled
};

// Cells of a box, one bit each.
class Marks {
 public:
  explicit Marks(const CellBox& box)
      : box_(box), bits_(static_cast<std::size_t>(box.width) * static_cast<std::size_t>(box.height)) {}

  bool Has(int column, int row) const { return bits_[IndexOf(column, row)]; }
  void Set(int column, int row) { bits_[IndexOf(column, row)] = true; }
  Patch ToPatch(const CellBox& box) const {
    PatchWriter writer(box);
    for (int row = box.first_row; row < box.end_row(); ++row) {
      for (int column = box.first_column; column < box.end_column(); ++column) {
        if (Has(column, row)) writer.Take(column, row);
      }
    }
    return std::move(writer).Finish();
  }

 private:
  std::size_t IndexOf(int column, int row) const {
    return static_cast<std::size_t>(row - box_.first_row) * static_cast<std::size_t>(box_.width) +
           static_cast<std::size_t>(column - box_.first_column);
  }

  CellBox box_;
  std::vector<bool> bits_;
};

}  // namespace

Patch PatchOf(const Overlay& marks, const CellBox& box) {
  PatchWriter writer(box);
  for (auto tile = marks.tiles().begin(); tile != marks.tiles().end();) {
    const int tile_row = tile->first.row;
    const auto next_row = marks.tiles().lower_bound({tile_row + 1, std::numeric_limits<int>::min()});
    for (int y = 0; y < kTileSize; ++y) {
      const int row = tile_row * kTileSize + y;
      if (row < box.first_row || row >= box.end_row()) continue;
      for (auto beside = tile; beside != next_row; ++beside) {
        const int left = beside->first.column * kTileSize;
        const int end = std::min(left + kTileSize, box.end_column());
        for (int column = std::max(left, box.first_column); column < end; ++column) {
          if (beside->second[PlaceInTile(column, row)] != 0) writer.Take(column, row);
        }
      }
    }
    tile = next_row;
  }
  return std::move(writer).Finish();
}

Patch CellsOf(const RegionMap& map, std::size_t region) {
  const CellBox& box = map.regions[region].box;
  PatchWriter writer(box);
  for (int row = box.first_row; row < box.end_row(); ++row) {
    for (int begin = box.first_column; begin < box.end_column();) {
      const grid::TileIndex index = TileOf(begin, row);
      const int end = std::min((index.column + 1) * kTileSize, box.end_column());
      const auto numbers = map.numbers.find(index);
      for (int column = begin; numbers != map.numbers.end() && column < end; ++column) {
        if (numbers->second[PlaceInTile(column, row)] == region + 1) writer.Take(column, row);
      }
      begin = end;
    }
  }
  return std::move(writer).Finish();
}

absl::StatusOr<Patch> CellsWhere(const Shape& shape, const std::vector<grid::CellClass>& classes, const CellBox& map,
                                 const ClassAt& class_at) {
  const CellBox box = Intersection(BoxOf(shape), map);
  if (box.empty()) return InvalidArgument("it lies outside of the map");
  Marks marks(box);
  bool any = false;
  VisitSpans(shape, [&](const Span& span) {
    if (span.row < box.first_row || span.row >= box.end_row()) return;
    for (int column = std::max(span.begin, box.first_column); column < std::min(span.end, box.end_column()); ++column) {
      if (std::find(classes.begin(), classes.end(), class_at(column, span.row)) == classes.end()) continue;
      marks.Set(column, span.row);
      any = true;
    }
  });
  if (!any) return InvalidArgument("none of its cells shows a class of only_where");
  return marks.ToPatch(box);
}

absl::StatusOr<Patch> FilledCells(LatticePoint seed, const CellBox& bounds, const CellBox& map,
                                  const ClassAt& class_at) {
  const CellBox box = Intersection(bounds, map);
  const int column = static_cast<int>(FloorDiv(seed.x, kUnitsPerCell));
  const int row = static_cast<int>(FloorDiv(seed.y, kUnitsPerCell));
  if (box.empty() || !box.contains(column, row))
    return InvalidArgument("its seed lies outside of the map or its bounds");
  const grid::CellClass wanted = class_at(column, row);
  Marks marks(box);
  marks.Set(column, row);
  std::vector<std::pair<int, int>> waiting{{column, row}};
  CellBox filled;
  std::int64_t cells = 0;
  while (!waiting.empty()) {
    const auto [x, y] = waiting.back();
    waiting.pop_back();
    if (++cells > kMaxCells) {
      return InvalidArgument("it fills more than {} cells: close the outline, or give narrower bounds", kMaxCells);
    }
    filled.Include(x, y);
    for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      if (!box.contains(x + dx, y + dy) || marks.Has(x + dx, y + dy) || class_at(x + dx, y + dy) != wanted) continue;
      marks.Set(x + dx, y + dy);
      waiting.emplace_back(x + dx, y + dy);
    }
  }
  return marks.ToPatch(filled);
}

}  // namespace enfilade::edit
