// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/geometry/pose2.h"

namespace enfilade::edit {

// What people say of a map's cells, which lies over what robots have seen. Shapes have integer coordinates, so that
// every program makes the same cells of them.

// The cells, without end in any direction: cell (column 0, row 0) begins at the origin.
struct Lattice {
  double resolution = 0.05;  // m, the side of a cell
  Pose2 T_map_lattice;       // the lower-left corner of cell (0, 0) in the map's frame

  friend bool operator==(const Lattice&, const Lattice&) = default;
};

constexpr std::int32_t kUnitsPerCell = 256;
constexpr std::int32_t kMaxCoordinate = 1 << 29;
constexpr std::int32_t kMaxSide = 1 << 22;  // of a segment, along each axis
constexpr std::int32_t kMaxRadius = 1 << 16;
constexpr std::size_t kMaxPoints = 10'000;
constexpr std::int64_t kMaxCells = 4'000'000;  // of one edit
constexpr std::size_t kMaxTiles = 1024;        // that one edit touches: each takes 64 KiB while it is drawn

// In 1/kUnitsPerCell of a cell: the centre of cell (c, r) is (256 c + 128, 256 r + 128).
struct LatticePoint {
  std::int32_t x = 0;
  std::int32_t y = 0;

  friend bool operator==(const LatticePoint&, const LatticePoint&) = default;
};

struct CellBox {
  int first_column = 0;
  int first_row = 0;
  int width = 0;
  int height = 0;

  bool empty() const { return width <= 0 || height <= 0; }
  int end_column() const { return first_column + width; }
  int end_row() const { return first_row + height; }
  bool contains(int column, int row) const {
    return column >= first_column && column < end_column() && row >= first_row && row < end_row();
  }
  // Makes it larger, so that it contains the cell.
  void Include(int column, int row) {
    if (empty()) {
      *this = {column, row, 1, 1};
      return;
    }
    const int right = end_column() > column ? end_column() : column + 1;
    const int top = end_row() > row ? end_row() : row + 1;
    if (column < first_column) first_column = column;
    if (row < first_row) first_row = row;
    width = right - first_column;
    height = top - first_row;
  }

  friend bool operator==(const CellBox&, const CellBox&) = default;
};

// Of a cell. The numbers are in the API and in stored tiles; kClear is only in drafts: there the cell has no edit any
// more.
enum class Instruction : std::uint8_t { kNone = 0, kUnknown = 1, kFree = 2, kOccupied = 3, kClear = 4 };

// A cell belongs to a shape if its centre is inside or on the edge.

// Within `radius` of the path; one point makes a disc.
struct Brush {
  std::vector<LatticePoint> points;
  std::int32_t radius = 0;

  friend bool operator==(const Brush&, const Brush&) = default;
};
// One cell wide: Bresenham's lines (grid::VisitLine) between the cells of the points.
struct Line {
  std::vector<LatticePoint> points;

  friend bool operator==(const Line&, const Line&) = default;
};
// Inside an odd number of rings, of at least three points each.
struct Polygon {
  std::vector<std::vector<LatticePoint>> rings;

  friend bool operator==(const Polygon&, const Polygon&) = default;
};
// Row by row from the box's lower left: how many cells to leave out, how many to take, and so on.
struct Patch {
  CellBox box;
  std::vector<std::uint32_t> runs;

  friend bool operator==(const Patch&, const Patch&) = default;
};

using Shape = std::variant<Brush, Line, Polygon, Patch>;

struct MapEdit {
  Instruction instruction = Instruction::kOccupied;  // not kNone
  Shape shape;
  bool invisible = false;  // occupied, by what scanners cannot see

  friend bool operator==(const MapEdit&, const MapEdit&) = default;
};

// INVALID_ARGUMENT naming what is wrong: no or too many points, coordinates or sides that are too large, a ring that
// crosses itself, runs that do not fit their box, more than kMaxCells or kMaxTiles.
absl::Status Validate(const Shape& shape);
// The same but for the cells, which takes long to find out.
absl::Status ValidateForm(const Shape& shape);

// For rows: versioned; the same shape gives the same bytes.
std::string Encode(const Shape& shape);
// DATA_LOSS on bytes that Encode did not write, FAILED_PRECONDITION on those of a newer version.
absl::StatusOr<Shape> DecodeShape(std::string_view bytes);

// The shape on another lattice: points are moved and rounded, radii and patches are scaled (cells by their centres).
Shape OnLattice(const Shape& shape, const Lattice& from, const Lattice& to);

}  // namespace enfilade::edit
