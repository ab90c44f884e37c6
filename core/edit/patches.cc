// SPDX-License-Identifier: Apache-2.0
#include "core/edit/patches.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/edit/integers.h"
#include "core/edit/spans.h"

namespace enfilade::edit {
namespace {

CellBox Intersection(const CellBox& a, const CellBox& b) {
  CellBox box{std::max(a.first_column, b.first_column), std::max(a.first_row, b.first_row), 0, 0};
  box.width = std::min(a.end_column(), b.end_column()) - box.first_column;
  box.height = std::min(a.end_row(), b.end_row()) - box.first_row;
  return box;
}

// Appends cells in the order of a patch.
class PatchWriter {
 public:
  explicit PatchWriter(const CellBox& box) { patch_.box = box; }

  void Add(bool takes) {
    if (takes != takes_) {
      patch_.runs.push_back(run_);
      run_ = 0;
      takes_ = takes;
    }
    ++run_;
  }
  Patch Finish() && {
    if (takes_) patch_.runs.push_back(run_);
    return std::move(patch_);
  }

 private:
  Patch patch_;
  bool takes_ = false;
  std::uint32_t run_ = 0;
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
      for (int column = box.first_column; column < box.end_column(); ++column) writer.Add(Has(column, row));
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
  for (int row = box.first_row; row < box.end_row(); ++row) {
    for (int column = box.first_column; column < box.end_column(); ++column) {
      writer.Add(marks.At(column, row) != Instruction::kNone);
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
