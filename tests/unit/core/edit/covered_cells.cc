// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/core/edit/covered_cells.h"

#include <algorithm>
#include <cstdlib>

#include "core/edit/spans.h"

namespace enfilade::edit {
namespace {

__extension__ using Wide = __int128;

struct WidePoint {
  Wide x = 0;
  Wide y = 0;
};

WidePoint Widened(LatticePoint point) { return {point.x, point.y}; }
Wide Squared(Wide value) { return value * value; }
Wide FloorOf(Wide value, Wide divisor) { return (value - ((value % divisor) + divisor) % divisor) / divisor; }

bool IsNear(WidePoint p, WidePoint a, WidePoint b, Wide radius) {
  const Wide dx = b.x - a.x;
  const Wide dy = b.y - a.y;
  const Wide along = (p.x - a.x) * dx + (p.y - a.y) * dy;
  const Wide length2 = Squared(dx) + Squared(dy);
  if (along <= 0) return Squared(p.x - a.x) + Squared(p.y - a.y) <= Squared(radius);
  if (along >= length2) return Squared(p.x - b.x) + Squared(p.y - b.y) <= Squared(radius);
  return Squared((p.x - a.x) * dy - (p.y - a.y) * dx) <= Squared(radius) * length2;
}

bool Covers(const Brush& brush, int column, int row) {
  const WidePoint p = Widened(Centre(column, row));
  for (std::size_t i = 0; i < brush.points.size(); ++i) {
    if (IsNear(p, Widened(brush.points[i == 0 ? 0 : i - 1]), Widened(brush.points[i]), brush.radius)) return true;
  }
  return false;
}

// The cell of a line at each step along its longer axis is the nearest to the line between the centres; of two, the one
// with the greater coordinate.
bool IsOnLine(LatticePoint from, LatticePoint to, Wide column, Wide row) {
  const WidePoint a{FloorOf(from.x, kUnitsPerCell), FloorOf(from.y, kUnitsPerCell)};
  const WidePoint b{FloorOf(to.x, kUnitsPerCell), FloorOf(to.y, kUnitsPerCell)};
  Wide along0 = a.x, along1 = b.x, across0 = a.y, across1 = b.y;
  const bool is_steep = std::abs(static_cast<long>(b.y - a.y)) > std::abs(static_cast<long>(b.x - a.x));
  if (is_steep) {
    std::swap(along0, across0);
    std::swap(along1, across1);
    std::swap(column, row);
  }
  if (column < std::min(along0, along1) || column > std::max(along0, along1)) return false;
  const Wide steps = along1 > along0 ? along1 - along0 : along0 - along1;
  if (steps == 0) return row == across0;
  const Wide done = column > along0 ? column - along0 : along0 - column;
  return row == FloorOf(2 * (across0 * steps + done * (across1 - across0)) + steps, 2 * steps);
}

bool Covers(const Line& line, int column, int row) {
  for (std::size_t i = 0; i < line.points.size(); ++i) {
    if (IsOnLine(line.points[i == 0 ? 0 : i - 1], line.points[i], column, row)) return true;
  }
  return false;
}

// Even-odd: counts the sides that a ray to the right crosses.
bool Covers(const Polygon& polygon, int column, int row) {
  const WidePoint p = Widened(Centre(column, row));
  bool inside = false;
  for (const std::vector<LatticePoint>& ring : polygon.rings) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const WidePoint a = Widened(ring[i]);
      const WidePoint b = Widened(ring[(i + 1) % ring.size()]);
      const Wide turn = (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
      if (turn == 0 && std::min(a.x, b.x) <= p.x && p.x <= std::max(a.x, b.x) && std::min(a.y, b.y) <= p.y &&
          p.y <= std::max(a.y, b.y)) {
        return true;
      }
      if ((a.y <= p.y) != (b.y <= p.y) && (turn > 0) == (b.y > a.y)) inside = !inside;
    }
  }
  return inside;
}

bool Covers(const Patch& patch, int column, int row) {
  if (!patch.box.contains(column, row)) return false;
  Wide left = Wide{row - patch.box.first_row} * patch.box.width + (column - patch.box.first_column);
  for (std::size_t i = 0; i < patch.runs.size(); ++i) {
    if (left < patch.runs[i]) return i % 2 == 1;
    left -= patch.runs[i];
  }
  return false;
}

char LetterOf(Instruction instruction) { return ".?-#x"[static_cast<int>(instruction)]; }

}  // namespace

bool IsCovered(const Shape& shape, int column, int row) {
  return std::visit([&](const auto& kind) { return Covers(kind, column, row); }, shape);
}

CellSet CoveredCells(const Shape& shape) {
  CellSet cells;
  const CellBox box = BoxOf(shape);
  for (int row = box.first_row - 2; row < box.end_row() + 2; ++row) {
    for (int column = box.first_column - 2; column < box.end_column() + 2; ++column) {
      if (IsCovered(shape, column, row)) cells.emplace(column, row);
    }
  }
  return cells;
}

CellSet DrawnCells(const Shape& shape) {
  CellSet cells;
  VisitSpans(shape, [&](const Span& span) {
    for (int column = span.begin; column < span.end; ++column) cells.emplace(column, span.row);
  });
  return cells;
}

Instruction InstructionOf(char letter) { return static_cast<Instruction>(std::string(".?-#x").find(letter)); }

Overlay OverlayIn(const std::vector<std::string>& picture, int column, int row) {
  Overlay overlay;
  const int height = static_cast<int>(picture.size());
  for (int y = 0; y < height; ++y) {
    const std::string& line = picture[static_cast<std::size_t>(height - 1 - y)];
    for (int x = 0; x < static_cast<int>(line.size()); ++x) {
      const Instruction instruction = InstructionOf(line[static_cast<std::size_t>(x)]);
      if (instruction != Instruction::kNone) overlay.Draw({instruction, Line{{Centre(column + x, row + y)}}, false});
    }
  }
  return overlay;
}

std::vector<std::string> PictureOf(const Overlay& overlay, const CellBox& box) {
  std::vector<std::string> picture;
  for (int row = box.end_row() - 1; row >= box.first_row; --row) {
    std::string& line = picture.emplace_back();
    for (int column = box.first_column; column < box.end_column(); ++column) line += LetterOf(overlay.At(column, row));
  }
  return picture;
}

std::vector<std::string> PictureOf(const Shape& shape, const CellBox& box) {
  Overlay overlay;
  overlay.Draw({Instruction::kOccupied, shape, false});
  return PictureOf(overlay, box);
}

LatticePoint Centre(int column, int row) {
  return {column * kUnitsPerCell + kUnitsPerCell / 2, row * kUnitsPerCell + kUnitsPerCell / 2};
}

std::vector<LatticePoint> Centres(const std::vector<std::pair<int, int>>& cells) {
  std::vector<LatticePoint> points;
  for (const auto& [column, row] : cells) points.push_back(Centre(column, row));
  return points;
}

}  // namespace enfilade::edit
