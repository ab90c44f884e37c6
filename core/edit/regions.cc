// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <optional>
#include <utility>

#include "core/edit/overlay.h"

namespace enfilade::edit {
namespace {

using grid::kTileSize;
using grid::TileIndex;

// Takes regions out of marks.
class RegionSearch {
 public:
  explicit RegionSearch(const Overlay& marks) : left_(marks.tiles()) {}

  // Empty if the cell is in a region already, or in none.
  std::optional<Region> Take(int column, int row) {
    std::uint8_t* const seed = Find(column, row);
    if (seed == nullptr || *seed == 0) return std::nullopt;
    const std::uint8_t value = std::exchange(*seed, 0);
    Region region{{column, row, 1, 1}, 0, column, row};
    ++number_;
    waiting_.assign(1, {column, row});
    while (!waiting_.empty()) {
      const auto [x, y] = waiting_.back();
      waiting_.pop_back();
      ++region.cells;
      region.box.Include(x, y);
      if (std::pair(y, x) < std::pair(region.row, region.column)) {
        region.row = y;
        region.column = x;
      }
      std::vector<std::uint32_t>& numbers = numbers_[TileOf(x, y)];
      numbers.resize(kCellsOfTile);
      numbers[PlaceInTile(x, y)] = number_;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) Reach(x + dx, y + dy, value);
      }
    }
    return region;
  }
  // Of each cell, the number of the call that has found its region.
  std::map<TileIndex, std::vector<std::uint32_t>> TakeNumbers() && { return std::move(numbers_); }

 private:
  std::uint8_t* Find(int column, int row) {
    const auto found = left_.find(TileOf(column, row));
    return found == left_.end() ? nullptr : &found->second[PlaceInTile(column, row)];
  }
  void Reach(int column, int row, std::uint8_t value) {
    std::uint8_t* const cell = Find(column, row);
    if (cell == nullptr || *cell != value) return;
    *cell = 0;
    waiting_.emplace_back(column, row);
  }

  std::map<TileIndex, TileCells> left_;
  std::map<TileIndex, std::vector<std::uint32_t>> numbers_;
  std::uint32_t number_ = 0;
  std::vector<std::pair<int, int>> waiting_;
};

}  // namespace

RegionMap MapRegions(const Overlay& marks) {
  RegionSearch search(marks);
  std::vector<std::pair<Region, std::uint32_t>> found;  // and its number in the search
  for (const auto& [index, cells] : marks.tiles()) {
    for (std::size_t place = 0; place < cells.size(); ++place) {
      if (cells[place] == 0) continue;
      const int column = index.column * kTileSize + static_cast<int>(place % kTileSize);
      const int row = index.row * kTileSize + static_cast<int>(place / kTileSize);
      if (const auto region = search.Take(column, row))
        found.emplace_back(*region, static_cast<std::uint32_t>(found.size() + 1));
    }
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
    return std::pair(a.first.row, a.first.column) < std::pair(b.first.row, b.first.column);
  });
  RegionMap map;
  std::vector<std::uint32_t> place(found.size() + 1);  // by the number in the search
  for (const auto& [region, number] : found) {
    map.regions.push_back(region);
    place[number] = static_cast<std::uint32_t>(map.regions.size());
  }
  map.numbers = std::move(search).TakeNumbers();
  for (auto& [index, numbers] : map.numbers) {
    for (std::uint32_t& number : numbers) number = place[number];
  }
  return map;
}

std::vector<Region> RegionsOf(const Overlay& marks) { return MapRegions(marks).regions; }

}  // namespace enfilade::edit
