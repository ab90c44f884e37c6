// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdlib>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/edit/map_edit.h"
#include "core/edit/overlay.h"
#include "core/edit/spans.h"

namespace enfilade::edit {
namespace {

// Rows that its segments span: bounds the work.
constexpr std::int64_t kMaxRows = 4'000'000;

absl::Status CheckPoints(const std::vector<LatticePoint>& points, bool is_ring, std::int32_t margin) {
  if (points.empty()) return InvalidArgument("it has no points");
  if (points.size() > kMaxPoints) {
    return InvalidArgument("it has {} points: at most {} are possible; split it", points.size(), kMaxPoints);
  }
  std::int64_t rows = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const LatticePoint& point = points[i];
    // A point at the limit plus the radius still has cells within an int.
    if (std::abs(std::int64_t{point.x}) > kMaxCoordinate || std::abs(std::int64_t{point.y}) > kMaxCoordinate) {
      return InvalidArgument("point {} is ({}, {}): coordinates are at most {}", i + 1, point.x, point.y,
                             kMaxCoordinate);
    }
    if (i == 0 && !is_ring) continue;
    const LatticePoint& before = points[i == 0 ? points.size() - 1 : i - 1];
    const std::int64_t dx = std::int64_t{point.x} - before.x;
    const std::int64_t dy = std::int64_t{point.y} - before.y;
    if (std::abs(dx) > kMaxSide || std::abs(dy) > kMaxSide) {
      return InvalidArgument("the segment to point {} is longer than {} cells: put points in between", i + 1,
                             kMaxSide / kUnitsPerCell);
    }
    rows += (std::abs(dy) + 2 * margin) / kUnitsPerCell + 1;
  }
  if (rows > kMaxRows) return InvalidArgument("its segments span {} rows: at most {}; split it", rows, kMaxRows);
  return absl::OkStatus();
}

absl::Status CheckShape(const Brush& brush) {
  if (brush.radius < 0 || brush.radius > kMaxRadius) {
    return InvalidArgument("radius is {}: expected 0 to {}", brush.radius, kMaxRadius);
  }
  return CheckPoints(brush.points, false, brush.radius);
}

absl::Status CheckShape(const Line& line) { return CheckPoints(line.points, false, 0); }

std::int64_t Turn(LatticePoint a, LatticePoint b, LatticePoint c) {
  return (std::int64_t{b.x} - a.x) * (std::int64_t{c.y} - a.y) - (std::int64_t{b.y} - a.y) * (std::int64_t{c.x} - a.x);
}
int Sign(std::int64_t value) { return value > 0 ? 1 : (value < 0 ? -1 : 0); }

// Whether the insides of two sides have exactly one point in common. Rings may touch themselves.
bool DoSidesCross(LatticePoint a, LatticePoint b, LatticePoint c, LatticePoint d) {
  return Sign(Turn(a, b, c)) * Sign(Turn(a, b, d)) < 0 && Sign(Turn(c, d, a)) * Sign(Turn(c, d, b)) < 0;
}

// Sides by their lowest row: only those that share rows are compared.
absl::Status CheckSimple(const std::vector<LatticePoint>& ring) {
  struct Side {
    std::size_t number;
    LatticePoint a, b;
    std::int32_t low, high;
  };
  std::vector<Side> sides;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const LatticePoint a = ring[i];
    const LatticePoint b = ring[(i + 1) % ring.size()];
    sides.push_back({i + 1, a, b, std::min(a.y, b.y), std::max(a.y, b.y)});
  }
  std::sort(sides.begin(), sides.end(), [](const Side& p, const Side& q) { return p.low < q.low; });
  for (std::size_t i = 0; i < sides.size(); ++i) {
    for (std::size_t j = i + 1; j < sides.size() && sides[j].low <= sides[i].high; ++j) {
      if (DoSidesCross(sides[i].a, sides[i].b, sides[j].a, sides[j].b)) {
        return InvalidArgument("sides {} and {} of a ring cross: draw it as several polygons",
                               std::min(sides[i].number, sides[j].number), std::max(sides[i].number, sides[j].number));
      }
    }
  }
  return absl::OkStatus();
}

absl::Status CheckShape(const Polygon& polygon) {
  if (polygon.rings.empty()) return InvalidArgument("it has no rings");
  std::size_t points = 0;
  for (const std::vector<LatticePoint>& ring : polygon.rings) {
    points += ring.size();
    if (ring.size() < 3) return InvalidArgument("a ring has {} points: expected at least 3", ring.size());
    if (points > kMaxPoints) return InvalidArgument("it has more than {} points: split it", kMaxPoints);
    ENFILADE_RETURN_IF_ERROR(CheckPoints(ring, true, 0));
    ENFILADE_RETURN_IF_ERROR(CheckSimple(ring));
  }
  return absl::OkStatus();
}

absl::Status CheckShape(const Patch& patch) {
  constexpr std::int64_t kLimit = kMaxCoordinate / kUnitsPerCell;
  const CellBox& box = patch.box;
  if (box.empty() || box.width > 2 * kLimit || box.height > 2 * kLimit ||
      std::abs(std::int64_t{box.first_column}) > kLimit || std::abs(std::int64_t{box.first_row}) > kLimit) {
    return InvalidArgument("its box has {} x {} cells from ({}, {}): expected at least one, within {} of the origin",
                           box.width, box.height, box.first_column, box.first_row, kLimit);
  }
  std::int64_t cells = 0;
  for (const std::uint32_t run : patch.runs) cells += run;
  if (cells > std::int64_t{box.width} * box.height) {
    return InvalidArgument("its runs have {} cells, more than the box of {} x {}", cells, box.width, box.height);
  }
  return absl::OkStatus();
}

// Cells that a shape covers, each once.
std::int64_t CountCells(const Shape& shape) {
  std::int64_t visits = 0;
  VisitSpans(shape, [&](const Span& span) { visits += span.end - span.begin; });
  if (visits <= kMaxCells || std::holds_alternative<Line>(shape) || std::holds_alternative<Patch>(shape)) return visits;
  std::vector<Span> spans;  // no more than kMaxRows for segments, and for sides
  VisitSpans(shape, [&](const Span& span) { spans.push_back(span); });
  std::sort(spans.begin(), spans.end(),
            [](const Span& a, const Span& b) { return std::pair(a.row, a.begin) < std::pair(b.row, b.begin); });
  std::int64_t cells = 0;
  int end = 0;  // of what is counted in the row
  for (std::size_t i = 0; i < spans.size(); ++i) {
    if (i == 0 || spans[i].row != spans[i - 1].row) end = spans[i].begin;
    cells += std::max(0, spans[i].end - std::max(end, spans[i].begin));
    end = std::max(end, spans[i].end);
  }
  return cells;
}

absl::Status CheckCells(const Shape& shape) {
  const std::int64_t cells = CountCells(shape);
  if (cells == 0) return InvalidArgument("it covers no cell");
  if (cells > kMaxCells) return InvalidArgument("it covers {} cells: at most {}; split it", cells, kMaxCells);
  const CellBox box = BoxOf(shape);
  const grid::TileIndex first = TileOf(box.first_column, box.first_row);
  const grid::TileIndex last = TileOf(box.end_column() - 1, box.end_row() - 1);
  const std::int64_t in_box = (std::int64_t{last.row} - first.row + 1) * (std::int64_t{last.column} - first.column + 1);
  if (in_box > std::int64_t{kMaxTiles} && TilesOf(shape, kMaxTiles).size() > kMaxTiles) {
    return InvalidArgument("it touches more than {} tiles of {} x {} cells: split it", kMaxTiles, grid::kTileSize,
                           grid::kTileSize);
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status ValidateForm(const Shape& shape) {
  return std::visit([](const auto& kind) { return CheckShape(kind); }, shape);
}

absl::Status Validate(const Shape& shape) {
  ENFILADE_RETURN_IF_ERROR(ValidateForm(shape));
  return CheckCells(shape);
}

}  // namespace enfilade::edit
