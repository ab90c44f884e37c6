// SPDX-License-Identifier: Apache-2.0
#include "core/edit/spans.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <utility>

#include "core/edit/integers.h"
#include "core/grid/bresenham.h"

namespace enfilade::edit {
namespace {

using grid::CellIndex;

constexpr std::int64_t kHalfCell = kUnitsPerCell / 2;

std::int64_t CentreOf(std::int64_t cell) { return cell * kUnitsPerCell + kHalfCell; }
// The first cell whose centre is not below `units`, and the last whose centre is not above.
int FirstFrom(std::int64_t units) { return static_cast<int>(CeilDiv(units - kHalfCell, kUnitsPerCell)); }
int LastUpTo(std::int64_t units) { return static_cast<int>(FloorDiv(units - kHalfCell, kUnitsPerCell)); }

// All points within a distance of a segment.
class Capsule {
 public:
  Capsule(LatticePoint a, LatticePoint b, std::int32_t radius)
      : a_(a),
        b_(b),
        dx_(std::int64_t{b.x} - a.x),
        dy_(std::int64_t{b.y} - a.y),
        radius2_(std::int64_t{radius} * radius),
        length2_(dx_ * dx_ + dy_ * dy_),
        max_cross_(RootOfProduct(static_cast<std::uint64_t>(radius2_), static_cast<std::uint64_t>(length2_))) {}

  bool Contains(std::int64_t x, std::int64_t y) const {
    const std::int64_t px = x - a_.x;
    const std::int64_t py = y - a_.y;
    const std::int64_t along = px * dx_ + py * dy_;
    if (along <= 0) return px * px + py * py <= radius2_;
    if (along >= length2_) {
      const std::int64_t qx = x - b_.x;
      const std::int64_t qy = y - b_.y;
      return qx * qx + qy * qy <= radius2_;
    }
    return std::abs(px * dy_ - py * dx_) <= max_cross_;
  }

  // A point of the row at `y` that is inside if any is: where the capsule's distance to the row is least.
  double NearestX(std::int64_t y) const {
    if (dy_ == 0) return 0.5 * (static_cast<double>(a_.x) + b_.x);
    const double t = std::clamp(static_cast<double>(y - a_.y) / static_cast<double>(dy_), 0.0, 1.0);
    return a_.x + t * static_cast<double>(dx_);
  }

 private:
  LatticePoint a_, b_;
  std::int64_t dx_, dy_, radius2_, length2_, max_cross_;
};

// A capsule meets a row in one interval: its ends are found from outside, exactly.
void VisitCapsule(LatticePoint a, LatticePoint b, std::int32_t radius, const VisitSpan& visit) {
  const Capsule capsule(a, b, radius);
  const std::int64_t left = std::int64_t{std::min(a.x, b.x)} - radius;
  const std::int64_t right = std::int64_t{std::max(a.x, b.x)} + radius;
  const int last_row = LastUpTo(std::int64_t{std::max(a.y, b.y)} + radius);
  for (int row = FirstFrom(std::int64_t{std::min(a.y, b.y)} - radius); row <= last_row; ++row) {
    const std::int64_t y = CentreOf(row);
    const auto is_inside = [&](int column) { return capsule.Contains(CentreOf(column), y); };
    // The cell nearest to the deepest point of the row; where the interval is narrow, one beside it.
    const int middle = static_cast<int>(std::floor(capsule.NearestX(y) / kUnitsPerCell));
    int inside = middle;
    bool found = false;
    for (const int column : {middle, middle - 1, middle + 1}) {
      if (is_inside(column)) {
        inside = column;
        found = true;
        break;
      }
    }
    if (!found) continue;
    const int begin = FirstTrue(FirstFrom(left), inside, is_inside);
    const int end = LastTrue(inside, LastUpTo(right), is_inside) + 1;
    visit({row, begin, end});
  }
}

void Visit(const Brush& brush, const VisitSpan& visit) {
  if (brush.points.size() == 1) VisitCapsule(brush.points[0], brush.points[0], brush.radius, visit);
  for (std::size_t i = 1; i < brush.points.size(); ++i) {
    VisitCapsule(brush.points[i - 1], brush.points[i], brush.radius, visit);
  }
}

CellIndex CellOf(LatticePoint point) {
  return {static_cast<int>(FloorDiv(point.x, kUnitsPerCell)), static_cast<int>(FloorDiv(point.y, kUnitsPerCell))};
}

void Visit(const Line& line, const VisitSpan& visit) {
  const auto one = [&](CellIndex cell) { visit({cell.row, cell.column, cell.column + 1}); };
  if (line.points.size() == 1) one(CellOf(line.points[0]));
  for (std::size_t i = 1; i < line.points.size(); ++i) {
    grid::VisitLine(CellOf(line.points[i - 1]), CellOf(line.points[i]), one);
  }
}

// Calls visit(a, b) for each side of each ring.
template <typename VisitSide>
void ForEachSide(const Polygon& polygon, VisitSide visit) {
  for (const std::vector<LatticePoint>& ring : polygon.rings) {
    for (std::size_t i = 0; i < ring.size(); ++i) visit(ring[i], ring[(i + 1) % ring.size()]);
  }
}

// Centres that lie on a side.
void VisitSide(LatticePoint a, LatticePoint b, const VisitSpan& visit) {
  if (a.y > b.y) std::swap(a, b);
  const std::int64_t height = std::int64_t{b.y} - a.y;
  for (int row = FirstFrom(a.y); row <= LastUpTo(b.y); ++row) {
    const std::int64_t y = CentreOf(row);
    if (height == 0) {
      const auto [low, high] = std::minmax(a.x, b.x);
      if (FirstFrom(low) <= LastUpTo(high)) visit({row, FirstFrom(low), LastUpTo(high) + 1});
      continue;
    }
    const std::int64_t across = (y - a.y) * (std::int64_t{b.x} - a.x);
    if (across % height != 0) continue;
    const std::int64_t x = a.x + across / height;
    if (FirstFrom(x) == LastUpTo(x)) visit({row, FirstFrom(x), FirstFrom(x) + 1});
  }
}

// Even-odd, row by row: each side that crosses the row toggles all cells whose centres are not left of it.
void Visit(const Polygon& polygon, const VisitSpan& visit) {
  std::map<int, std::vector<int>> toggles;  // by row: columns
  ForEachSide(polygon, [&](LatticePoint a, LatticePoint b) {
    if (a.y == b.y) return;
    if (a.y > b.y) std::swap(a, b);
    const std::int64_t height = std::int64_t{b.y} - a.y;
    for (int row = FirstFrom(a.y); CentreOf(row) < b.y; ++row) {
      const std::int64_t scaled = (a.x - kHalfCell) * height + (CentreOf(row) - a.y) * (std::int64_t{b.x} - a.x);
      toggles[row].push_back(static_cast<int>(CeilDiv(scaled, kUnitsPerCell * height)));
    }
  });
  for (auto& [row, columns] : toggles) {
    std::sort(columns.begin(), columns.end());
    for (std::size_t i = 0; i + 1 < columns.size(); i += 2) {
      if (columns[i] < columns[i + 1]) visit({row, columns[i], columns[i + 1]});
    }
  }
  ForEachSide(polygon, [&](LatticePoint a, LatticePoint b) { VisitSide(a, b, visit); });
}

void Visit(const Patch& patch, const VisitSpan& visit) {
  std::int64_t at = 0;
  bool takes = false;
  const std::int64_t width = patch.box.width;
  for (const std::uint32_t run : patch.runs) {
    for (std::int64_t left = takes ? run : 0; left > 0;) {
      const std::int64_t column = at % width;
      const std::int64_t here = std::min(left, width - column);
      const int begin = patch.box.first_column + static_cast<int>(column);
      visit({patch.box.first_row + static_cast<int>(at / width), begin, begin + static_cast<int>(here)});
      at += here;
      left -= here;
    }
    if (!takes) at += run;
    takes = !takes;
  }
}

CellBox BoxOfPoints(const std::vector<LatticePoint>& points, std::int32_t margin, CellBox box) {
  for (const LatticePoint& point : points) {
    const CellIndex low = CellOf({point.x - margin, point.y - margin});
    const CellIndex high = CellOf({point.x + margin, point.y + margin});
    box.Include(low.column, low.row);
    box.Include(high.column, high.row);
  }
  return box;
}

}  // namespace

void VisitSpans(const Shape& shape, const VisitSpan& visit) {
  std::visit([&](const auto& kind) { Visit(kind, visit); }, shape);
}

CellBox BoxOf(const Shape& shape) {
  if (const auto* const brush = std::get_if<Brush>(&shape)) return BoxOfPoints(brush->points, brush->radius, {});
  if (const auto* const line = std::get_if<Line>(&shape)) return BoxOfPoints(line->points, 0, {});
  if (const auto* const patch = std::get_if<Patch>(&shape)) return patch->box;
  CellBox box;
  for (const auto& ring : std::get<Polygon>(shape).rings) box = BoxOfPoints(ring, 0, box);
  return box;
}

}  // namespace enfilade::edit
