// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "core/edit/map_edit.h"
#include "core/edit/overlay.h"
#include "core/edit/patches.h"
#include "core/edit/spans.h"

namespace enfilade::edit {
namespace {

// From one lattice's coordinates to another's, in units.
class LatticeChange {
 public:
  LatticeChange(const Lattice& from, const Lattice& to)
      : T_to_from_(Between(to.T_map_lattice, from.T_map_lattice)),
        from_unit_(from.resolution / kUnitsPerCell),
        to_unit_(to.resolution / kUnitsPerCell) {}

  Eigen::Vector2d Apply(const Eigen::Vector2d& units) const { return T_to_from_ * (units * from_unit_) / to_unit_; }
  LatticePoint Apply(LatticePoint point) const { return Rounded(Apply(Eigen::Vector2d(point.x, point.y))); }
  std::vector<LatticePoint> Apply(const std::vector<LatticePoint>& points) const {
    std::vector<LatticePoint> changed;
    for (const LatticePoint& point : points) changed.push_back(Apply(point));
    return changed;
  }
  std::int32_t Length(std::int32_t units) const {
    return static_cast<std::int32_t>(std::clamp(std::round(units * from_unit_ / to_unit_), 0.0, double{kMaxRadius}));
  }
  static LatticePoint Rounded(const Eigen::Vector2d& units) {
    const auto round = [](double value) {
      return static_cast<std::int32_t>(std::clamp(std::round(value), double{-kMaxCoordinate}, double{kMaxCoordinate}));
    };
    return {round(units.x()), round(units.y())};
  }

 private:
  Pose2 T_to_from_;
  double from_unit_, to_unit_;
};

Shape Change(const Brush& brush, const LatticeChange& change, const LatticeChange&) {
  return Brush{change.Apply(brush.points), change.Length(brush.radius)};
}
Shape Change(const Line& line, const LatticeChange& change, const LatticeChange&) {
  return Line{change.Apply(line.points)};
}
Shape Change(const Polygon& polygon, const LatticeChange& change, const LatticeChange&) {
  Polygon changed;
  for (const auto& ring : polygon.rings) changed.rings.push_back(change.Apply(ring));
  return changed;
}

// The box around the marked cells of a tile.
CellBox BoxOfMarks(grid::TileIndex tile, const TileCells& cells) {
  CellBox box;
  for (std::size_t place = 0; place < cells.size(); ++place) {
    if (cells[place] == 0) continue;
    box.Include(tile.column * grid::kTileSize + static_cast<int>(place % grid::kTileSize),
                tile.row * grid::kTileSize + static_cast<int>(place / grid::kTileSize));
  }
  return box;
}

// The box around a box's cells on the other lattice.
CellBox BoxOnOther(const CellBox& cells, const LatticeChange& change) {
  CellBox box;
  for (const int column : {cells.first_column, cells.end_column()}) {
    for (const int row : {cells.first_row, cells.end_row()}) {
      const LatticePoint corner = change.Apply(LatticePoint{column * kUnitsPerCell, row * kUnitsPerCell});
      box.Include(corner.x >> 8, corner.y >> 8);
    }
  }
  return box;
}

// Each new cell is taken whose centre lies in one that was. A patch may have few cells in a large box: only its tiles
// are looked at.
Shape Change(const Patch& patch, const LatticeChange& change, const LatticeChange& back) {
  Overlay marks;
  marks.Draw({Instruction::kOccupied, patch, false});
  Overlay changed;
  CellBox box;
  for (const auto& [index, cells] : marks.tiles()) {
    const CellBox near = BoxOnOther(BoxOfMarks(index, cells), change);
    for (int row = near.first_row; row < near.end_row(); ++row) {
      for (int column = near.first_column; column < near.end_column(); ++column) {
        const Eigen::Vector2d centre((column + 0.5) * kUnitsPerCell, (row + 0.5) * kUnitsPerCell);
        const Eigen::Vector2d before = back.Apply(centre) / kUnitsPerCell;
        const int old_column = static_cast<int>(std::floor(before.x()));
        const int old_row = static_cast<int>(std::floor(before.y()));
        if (TileOf(old_column, old_row) != index || cells[PlaceInTile(old_column, old_row)] == 0) continue;
        const LatticePoint point{column * kUnitsPerCell, row * kUnitsPerCell};
        changed.Draw({Instruction::kOccupied, Line{{point}}, false});
        box.Include(column, row);
      }
    }
  }
  if (box.empty()) box = {0, 0, 1, 1};  // every cell was smaller than one of the new lattice
  return PatchOf(changed, box);
}

}  // namespace

Shape OnLattice(const Shape& shape, const Lattice& from, const Lattice& to) {
  if (from == to) return shape;
  const LatticeChange change(from, to);
  const LatticeChange back(to, from);
  return std::visit([&](const auto& kind) { return Change(kind, change, back); }, shape);
}

}  // namespace enfilade::edit
