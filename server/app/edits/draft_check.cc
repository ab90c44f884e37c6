// SPDX-License-Identifier: Apache-2.0
#include "server/app/edits/draft_check.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "fmt/format.h"

namespace enfilade::server {
namespace {

using edit::Instruction;
using grid::CellClass;
using grid::kTileSize;

// Half the width of the free way that a robot needs at a link point, m.
constexpr double kClearance = 0.3;
// Within which a link point's free cells are looked for, m: anchors lie in doors, up to where their leaves are.
constexpr double kReach = 0.5;

template <typename Visit>
void ForEachEditedCell(const edit::Overlay& overlay, Visit visit) {
  for (const auto& [index, cells] : overlay.tiles()) {
    for (std::size_t place = 0; place < cells.size(); ++place) {
      if (cells[place] == 0) continue;
      visit(index.column * kTileSize + static_cast<int>(place % kTileSize),
            index.row * kTileSize + static_cast<int>(place / kTileSize));
    }
  }
}

}  // namespace

CellClass DraftComparison::Class(Instruction edited, int column, int row) const {
  switch (edited) {
    case Instruction::kUnknown:
      return CellClass::kUnknown;
    case Instruction::kFree:
      return CellClass::kFree;
    case Instruction::kOccupied:
      return CellClass::kOccupied;
    default:
      return ground_.At(column, row);
  }
}

void DraftComparison::Count(ChangeCounts& changes, edit::CellBox& box) const {
  static const edit::TileCells nothing(edit::kCellsOfTile, 0);
  const auto compare = [&](const grid::TileIndex& index, const edit::TileCells* is, const edit::TileCells* becomes) {
    const std::uint8_t* const before = (is != nullptr ? *is : nothing).data();
    const std::uint8_t* const after = (becomes != nullptr ? *becomes : nothing).data();
    for (std::size_t place = 0; place < edit::kCellsOfTile; ++place) {
      if (before[place] == after[place]) continue;
      const int column = index.column * kTileSize + static_cast<int>(place % kTileSize);
      const int row = index.row * kTileSize + static_cast<int>(place / kTileSize);
      if (!ground_.box.contains(column, row)) continue;
      const CellClass now = Class(static_cast<Instruction>(after[place]), column, row);
      if (now == Class(static_cast<Instruction>(before[place]), column, row)) continue;
      box.Include(column, row);
      ++(now == CellClass::kFree      ? changes.to_free
         : now == CellClass::kUnknown ? changes.to_unknown
                                      : changes.to_occupied);
    }
  };
  for (const auto& [index, cells] : after_.tiles()) compare(index, before_.Find(index), &cells);
  for (const auto& [index, cells] : before_.tiles()) {
    if (after_.Find(index) == nullptr) compare(index, &cells, nullptr);
  }
}

std::int64_t DraftComparison::CellsOutside(const edit::Overlay& layer) const {
  std::int64_t outside = 0;
  ForEachEditedCell(layer, [&](int column, int row) { outside += ground_.box.contains(column, row) ? 0 : 1; });
  return outside;
}

edit::CellBox DraftComparison::CellsAround(const PlaceInMap& place) const {
  const double cell = ground_.lattice.resolution;
  const Eigen::Vector2d at = Inverse(ground_.lattice.T_map_lattice) * place.point_map / cell;
  const int reach = static_cast<int>(std::ceil(kReach / cell));
  const int column = static_cast<int>(std::floor(at.x()));
  const int row = static_cast<int>(std::floor(at.y()));
  return {column - reach, row - reach, 2 * reach + 1, 2 * reach + 1};
}

// Parts of the free ground are numbered by a flood from each place; places in one part have the same number. -1: the
// place has no free cell.
std::vector<int> DraftComparison::ReachableParts(const edit::Overlay& overlay,
                                                 const std::vector<PlaceInMap>& places) const {
  const edit::CellBox& box = ground_.box;
  std::vector<int> part_of(ground_.classes.size(), -1);
  const auto index_of = [&](int column, int row) {
    return static_cast<std::size_t>(row - box.first_row) * static_cast<std::size_t>(box.width) +
           static_cast<std::size_t>(column - box.first_column);
  };
  std::vector<std::pair<int, int>> waiting;
  const auto reach = [&](int column, int row, int part) {
    if (!box.contains(column, row) || part_of[index_of(column, row)] >= 0) return;
    if (Class(overlay.At(column, row), column, row) != CellClass::kFree) return;
    part_of[index_of(column, row)] = part;
    waiting.emplace_back(column, row);
  };
  std::vector<int> parts;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const edit::CellBox around = CellsAround(places[i]);
    int part = -1;
    for (int row = around.first_row; row < around.end_row() && part < 0; ++row) {
      for (int column = around.first_column; column < around.end_column() && part < 0; ++column) {
        if (!box.contains(column, row) || Class(overlay.At(column, row), column, row) != CellClass::kFree) continue;
        reach(column, row, static_cast<int>(i));
        part = part_of[index_of(column, row)];
      }
    }
    while (!waiting.empty()) {
      const auto [x, y] = waiting.back();
      waiting.pop_back();
      for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}})
        reach(x + dx, y + dy, static_cast<int>(i));
    }
    parts.push_back(part);
  }
  return parts;
}

void DraftComparison::CheckPlaces(const std::vector<PlaceInMap>& places, std::vector<DraftProblem>& problems) const {
  if (places.empty()) return;
  const int clearance = static_cast<int>(std::ceil(kClearance / ground_.lattice.resolution));
  for (const PlaceInMap& place : places) {
    const edit::CellBox around = CellsAround(place);
    const int column = around.first_column + around.width / 2;
    const int row = around.first_row + around.height / 2;
    std::int64_t obstacles = 0;
    for (int y = row - clearance; y <= row + clearance; ++y) {
      for (int x = column - clearance; x <= column + clearance; ++x) {
        if ((x - column) * (x - column) + (y - row) * (y - row) > clearance * clearance) continue;
        obstacles += Class(after_.At(x, y), x, y) == CellClass::kOccupied &&
                     Class(before_.At(x, y), x, y) != CellClass::kOccupied;
      }
    }
    if (obstacles == 0) continue;
    problems.push_back({false,
                        fmt::format("{} new occupied cells lie within {} m of {}: robots may no longer get through",
                                    obstacles, kClearance, place.name),
                        edit::CellBox{column - clearance, row - clearance, 2 * clearance + 1, 2 * clearance + 1}});
  }
  const std::vector<int> before = ReachableParts(before_, places);
  const std::vector<int> after = ReachableParts(after_, places);
  for (std::size_t i = 1; i < places.size(); ++i) {
    const bool was_joined = before[i] >= 0 && before[i] == before[0];
    if (was_joined && (after[i] < 0 || after[i] != after[0])) {
      problems.push_back({false, fmt::format("{} is cut off from {}: no free cells lead from one to the other any more",
                                             places[i].name, places[0].name)});
    }
  }
}

}  // namespace enfilade::server
