// SPDX-License-Identifier: Apache-2.0
#include "core/grid/raster_pyramid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "core/grid/occupancy_values.h"
#include "core/grid/tile_codec.h"

namespace enfilade::grid {
namespace {

using TileCells = std::vector<std::uint8_t>;
using Children = std::array<std::string, 4>;  // digests: lower left, lower right, upper left, upper right; empty: none

constexpr std::size_t kCellsOfTile = std::size_t{kTileSize} * kTileSize;
constexpr int kHalf = kTileSize / 2;

// What wins in a cell that stands for several: 0 unknown, above it free (the freer the greater), above that occupied.
std::array<std::uint16_t, 256> RanksOfCells() {
  const std::array<CellClass, 256> classes = ClassesOfCells();
  std::array<std::uint16_t, 256> ranks{};
  for (std::size_t cell = 0; cell < ranks.size(); ++cell) {
    if (classes[cell] == CellClass::kOccupied) ranks[cell] = static_cast<std::uint16_t>(0x200 + cell);
    if (classes[cell] == CellClass::kFree) ranks[cell] = static_cast<std::uint16_t>(0x1ff - cell);
  }
  return ranks;
}

std::uint8_t CellOfRank(std::uint16_t rank) {
  if (rank >= 0x200) return static_cast<std::uint8_t>(rank - 0x200);
  return rank == 0 ? kUnknownCell : static_cast<std::uint8_t>(0x1ff - rank);
}

int FloorHalf(int value) { return value >> 1; }  // also of negative ones (C++20)

Children ChildrenOf(const RasterPyramid::Level& level, TileIndex parent) {
  Children children;
  for (int i = 0; i < 4; ++i) {
    const auto found = level.find({parent.row * 2 + i / 2, parent.column * 2 + i % 2});
    if (found != level.end()) children[static_cast<std::size_t>(i)] = found->second;
  }
  return children;
}

bool IsLast(const RasterPyramid::Level& level) {
  constexpr int kMax = std::numeric_limits<int>::max();
  TileIndex low{kMax, kMax}, high{-kMax, -kMax};
  for (const auto& [index, sha256] : level) {
    low = {std::min(low.row, index.row), std::min(low.column, index.column)};
    high = {std::max(high.row, index.row), std::max(high.column, index.column)};
  }
  const auto ends = [](int first, int last) { return first >= last || (first == -1 && last == 0); };
  return ends(low.row, high.row) && ends(low.column, high.column);
}

class Builder {
 public:
  Builder(const std::vector<RasterPyramid::Level>& before, const LoadTile& load) : before_(before), load_(load) {}

  absl::StatusOr<RasterPyramid> Build(RasterPyramid::Level tiles) {
    pyramid_.levels.push_back(std::move(tiles));
    while (!IsLast(pyramid_.levels.back())) {
      ENFILADE_ASSIGN_OR_RETURN(RasterPyramid::Level next, MakeLevel(pyramid_.levels.size()));
      pyramid_.levels.push_back(std::move(next));
    }
    return std::move(pyramid_);
  }

 private:
  absl::StatusOr<RasterPyramid::Level> MakeLevel(std::size_t zoom) {
    const RasterPyramid::Level& below = pyramid_.levels[zoom - 1];
    RasterPyramid::Level level;
    for (const auto& [index, sha256] : below) {
      const TileIndex parent{FloorHalf(index.row), FloorHalf(index.column)};
      if (level.contains(parent)) continue;
      const Children children = ChildrenOf(below, parent);
      std::optional<std::string> digest = FindBefore(zoom, parent, children);
      if (!digest) {
        ENFILADE_ASSIGN_OR_RETURN(digest, MakeParent(children));
      }
      level.emplace(parent, *std::move(digest));
    }
    std::erase_if(level, [](const auto& tile) { return tile.second.empty(); });  // unknown throughout
    return level;
  }

  // The parent of the same children in the earlier pyramid; empty if it was unknown throughout.
  std::optional<std::string> FindBefore(std::size_t zoom, TileIndex parent, const Children& children) const {
    if (zoom >= before_.size() || ChildrenOf(before_[zoom - 1], parent) != children) return std::nullopt;
    const auto found = before_[zoom].find(parent);
    return found == before_[zoom].end() ? std::string() : found->second;
  }

  absl::StatusOr<std::string> MakeParent(const Children& children) {
    TileCells cells(kCellsOfTile, kUnknownCell);
    bool is_known = false;
    for (std::size_t i = 0; i < children.size(); ++i) {
      if (children[i].empty()) continue;
      ENFILADE_RETURN_IF_ERROR(Read(children[i]));
      is_known = Shrink(static_cast<int>(i) / 2 * kHalf, static_cast<int>(i) % 2 * kHalf, cells) || is_known;
    }
    if (!is_known) return std::string();
    std::string bytes = packing_.Pack(cells);
    std::string digest = Sha256(bytes);
    pyramid_.made.emplace(digest, std::move(bytes));
    return digest;
  }

  absl::Status Read(const std::string& sha256) {
    child_.resize(kCellsOfTile);
    const auto made = pyramid_.made.find(sha256);
    if (made != pyramid_.made.end()) return packing_.Unpack(made->second, absl::MakeSpan(child_));
    ENFILADE_ASSIGN_OR_RETURN(const std::string bytes, load_(sha256));
    return packing_.Unpack(bytes, absl::MakeSpan(child_));
  }

  // Writes `child_` at half its size into a quarter of its parent. False if it is unknown throughout.
  bool Shrink(int row, int column, TileCells& parent) const {
    bool is_known = false;
    for (int y = 0; y < kHalf; ++y) {
      const std::uint8_t* const lower = child_.data() + static_cast<std::size_t>(2 * y) * kTileSize;
      const std::uint8_t* const upper = lower + kTileSize;
      std::uint8_t* const out = parent.data() + static_cast<std::size_t>(row + y) * kTileSize + column;
      for (int x = 0; x < kHalf; ++x) {
        const std::uint16_t rank = std::max(std::max(ranks_[lower[2 * x]], ranks_[lower[2 * x + 1]]),
                                            std::max(ranks_[upper[2 * x]], ranks_[upper[2 * x + 1]]));
        out[x] = CellOfRank(rank);
        is_known = is_known || rank != 0;
      }
    }
    return is_known;
  }

  const std::array<std::uint16_t, 256> ranks_ = RanksOfCells();
  const std::vector<RasterPyramid::Level>& before_;
  const LoadTile& load_;
  TilePacking packing_;
  TileCells child_;
  RasterPyramid pyramid_;
};

// Cells of the thumbnail's zoom: a frame around the grid.
Thumbnail FrameOf(int top, CellIndex min, int width, int height) {
  Thumbnail thumbnail;
  thumbnail.zoom = top - 1;
  do {
    ++thumbnail.zoom;
    thumbnail.lower_left = {min.column >> thumbnail.zoom, min.row >> thumbnail.zoom};
    thumbnail.width = ((min.column + width - 1) >> thumbnail.zoom) - thumbnail.lower_left.column + 1;
    thumbnail.height = ((min.row + height - 1) >> thumbnail.zoom) - thumbnail.lower_left.row + 1;
  } while (thumbnail.width > kThumbnailSide || thumbnail.height > kThumbnailSide);
  thumbnail.classes.assign(static_cast<std::size_t>(thumbnail.width) * static_cast<std::size_t>(thumbnail.height), 0);
  return thumbnail;
}

void AddToThumbnail(TileIndex index, const TileCells& cells, int shift, Thumbnail& thumbnail) {
  static const std::array<CellClass, 256> classes = ClassesOfCells();
  for (int y = 0; y < kTileSize; ++y) {
    const int row = ((index.row * kTileSize + y) >> shift) - thumbnail.lower_left.row;
    if (row < 0 || row >= thumbnail.height) continue;
    for (int x = 0; x < kTileSize; ++x) {
      const int column = ((index.column * kTileSize + x) >> shift) - thumbnail.lower_left.column;
      if (column < 0 || column >= thumbnail.width) continue;
      const std::uint8_t cell = cells[static_cast<std::size_t>(y) * kTileSize + static_cast<std::size_t>(x)];
      std::uint8_t& out = thumbnail.classes[static_cast<std::size_t>(row) * static_cast<std::size_t>(thumbnail.width) +
                                            static_cast<std::size_t>(column)];
      out = std::max(out, static_cast<std::uint8_t>(classes[cell]));  // in the order of the classes: occupied wins
    }
  }
}

}  // namespace

std::array<CellClass, 256> ClassesOfCells() {
  const GreySaveOptions options;
  std::array<CellClass, 256> classes{};
  for (std::size_t cell = 1; cell < classes.size(); ++cell) {
    const int value = OccupancyValueOfCell(static_cast<std::uint8_t>(cell));
    if (value >= std::lround(100 * options.occupied_thresh)) {
      classes[cell] = CellClass::kOccupied;
    } else if (value <= std::lround(100 * options.free_thresh)) {
      classes[cell] = CellClass::kFree;
    }
  }
  return classes;
}

absl::StatusOr<RasterPyramid> BuildPyramid(RasterPyramid::Level tiles, const std::vector<RasterPyramid::Level>& before,
                                           const LoadTile& load) {
  return Builder(before, load).Build(std::move(tiles));
}

absl::StatusOr<Thumbnail> MakeThumbnail(const RasterPyramid& pyramid, CellIndex lattice_min, int width, int height,
                                        const LoadTile& load) {
  const int top = static_cast<int>(pyramid.levels.size()) - 1;
  Thumbnail thumbnail = FrameOf(top, lattice_min, width, height);
  TilePacking packing;
  TileCells cells(kCellsOfTile);
  for (const auto& [index, sha256] : pyramid.levels.back()) {
    const auto made = pyramid.made.find(sha256);
    std::string bytes;
    if (made != pyramid.made.end()) {
      bytes = made->second;
    } else {
      ENFILADE_ASSIGN_OR_RETURN(bytes, load(sha256));
    }
    ENFILADE_RETURN_IF_ERROR(packing.Unpack(bytes, absl::MakeSpan(cells)));
    AddToThumbnail(index, cells, thumbnail.zoom - top, thumbnail);
  }
  return thumbnail;
}

}  // namespace enfilade::grid
