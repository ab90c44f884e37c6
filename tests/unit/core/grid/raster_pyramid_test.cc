// SPDX-License-Identifier: Apache-2.0
#include "core/grid/raster_pyramid.h"

#include <gtest/gtest.h>

#include <random>

#include "core/base/sha256.h"
#include "core/grid/tile_codec.h"
#include "tests/support/status_assertions.h"

namespace enfilade::grid {
namespace {

constexpr std::uint8_t kFree = 20;
constexpr std::uint8_t kWall = 240;
constexpr std::uint8_t kUnsure = 128;

// A grid on the lattice of its map's frame, as it is stored.
class StoredGrid {
 public:
  StoredGrid(int column, int row, int width, int height) : min_{column, row} {
    grid_.geometry = {0.05, {column * 0.05, row * 0.05, 0.0}, width, height};
    grid_.cells.assign(grid_.geometry.cell_count(), kUnknownCell);
  }

  std::uint8_t& at(int column, int row) {
    return grid_.cells[grid_.geometry.index(column - min_.column, row - min_.row)];
  }
  std::uint8_t Find(int column, int row) const {
    const int x = column - min_.column;
    const int y = row - min_.row;
    return grid_.geometry.contains(x, y) ? grid_.cells[grid_.geometry.index(x, y)] : kUnknownCell;
  }
  const OccupancyGrid& grid() const { return grid_; }
  CellIndex min() const { return min_; }

  RasterPyramid Build(const std::vector<RasterPyramid::Level>& before = {}) {
    RasterPyramid::Level tiles;
    for (const auto& [index, bytes] : SplitIntoTiles(FromOccupancyGrid(grid_)).tiles) {
      tiles[index] = Sha256(bytes);
      blobs_[tiles[index]] = bytes;
    }
    auto pyramid = BuildPyramid(tiles, before, load());
    EXPECT_OK(pyramid);
    for (const auto& [sha256, bytes] : pyramid->made) blobs_[sha256] = bytes;
    return *std::move(pyramid);
  }
  LoadTile load() {
    return [this](std::string_view sha256) -> absl::StatusOr<std::string> {
      ++loads;
      return blobs_.at(std::string(sha256));
    };
  }
  // A cell of the pyramid.
  std::uint8_t CellOf(const RasterPyramid& pyramid, int zoom, int column, int row) {
    const auto& level = pyramid.levels[static_cast<std::size_t>(zoom)];
    const auto found = level.find({row >> 8, column >> 8});
    if (found == level.end()) return kUnknownCell;
    std::vector<std::uint8_t> cells(65536);
    EXPECT_OK(TilePacking().Unpack(blobs_.at(found->second), absl::MakeSpan(cells)));
    return cells[static_cast<std::size_t>(row & 255) * 256 + static_cast<std::size_t>(column & 255)];
  }

  int loads = 0;

 private:
  CellIndex min_;
  OccupancyGrid grid_;
  std::map<std::string, std::string> blobs_;
};

TEST(RasterPyramidTest, AWallOfOneCellSurvivesAtEveryZoom) {
  StoredGrid stored(-700, -300, 3000, 1500);
  for (int column = -700; column < 2300; ++column) {
    for (int row = -300; row < 1200; ++row) stored.at(column, row) = kFree;
  }
  for (int column = -600; column < 2200; ++column) stored.at(column, 77) = kWall;
  const RasterPyramid pyramid = stored.Build();
  ASSERT_GE(pyramid.levels.size(), 4U);
  for (int zoom = 0; zoom < static_cast<int>(pyramid.levels.size()); ++zoom) {
    for (const int column : {-600, -1, 0, 1000, 2199}) {
      EXPECT_EQ(stored.CellOf(pyramid, zoom, column >> zoom, 77 >> zoom), kWall) << zoom;
      EXPECT_EQ(stored.CellOf(pyramid, zoom, column >> zoom, 1100 >> zoom), kFree) << zoom;
    }
  }
}

TEST(RasterPyramidTest, OccupiedWinsThenFreeThenUnknown) {
  StoredGrid stored(0, 0, 600, 600);
  stored.at(2, 0) = kWall - 5;
  stored.at(3, 1) = kWall;
  stored.at(4, 0) = kFree;
  stored.at(5, 1) = kFree - 5;
  stored.at(6, 0) = kUnsure;
  stored.at(599, 599) = kFree;  // so that there is more than one tile
  const RasterPyramid pyramid = stored.Build();
  EXPECT_EQ(stored.CellOf(pyramid, 1, 1, 0), kWall);
  EXPECT_EQ(stored.CellOf(pyramid, 1, 2, 0), kFree - 5);
  EXPECT_EQ(stored.CellOf(pyramid, 1, 3, 0), kUnknownCell);
}

TEST(RasterPyramidTest, EveryCellIsWhatTheRuleSays) {
  std::mt19937 random(7);
  StoredGrid stored(-300, -1000, 900, 1300);
  for (int i = 0; i < 3000; ++i) {
    stored.at(-300 + static_cast<int>(random() % 900), -1000 + static_cast<int>(random() % 1300)) =
        static_cast<std::uint8_t>(random());
  }
  const RasterPyramid pyramid = stored.Build();
  const auto classes = ClassesOfCells();
  for (int zoom = 1; zoom < static_cast<int>(pyramid.levels.size()); ++zoom) {
    for (int i = 0; i < 40; ++i) {
      const int column = (-300 + static_cast<int>(random() % 900)) >> zoom;
      const int row = (-1000 + static_cast<int>(random() % 1300)) >> zoom;
      int wall = 0, free = 256;
      for (int c = column << zoom; c < (column + 1) << zoom; ++c) {
        for (int r = row << zoom; r < (row + 1) << zoom; ++r) {
          const std::uint8_t cell = stored.Find(c, r);
          if (classes[cell] == CellClass::kOccupied) wall = std::max<int>(wall, cell);
          if (classes[cell] == CellClass::kFree) free = std::min<int>(free, cell);
        }
      }
      EXPECT_EQ(stored.CellOf(pyramid, zoom, column, row), wall > 0 ? wall : free < 256 ? free : 0);
    }
  }
}

TEST(RasterPyramidTest, EndsWithOneTileOrThoseAroundTheOrigin) {
  EXPECT_EQ(StoredGrid(0, 0, 10, 10).Build().levels.size(), 1U);
  StoredGrid beside(256, 0, 512, 10);
  for (int column = 256; column < 768; ++column) beside.at(column, 0) = kFree;
  EXPECT_EQ(beside.Build().levels.back().size(), 1U);
  StoredGrid around(-256, -256, 512, 512);
  for (int i = -256; i < 256; ++i) around.at(i, i) = around.at(i, -1 - i) = kWall;
  const RasterPyramid pyramid = around.Build();
  EXPECT_EQ(pyramid.levels.size(), 1U);
  EXPECT_EQ(pyramid.levels.back().size(), 4U);
}

TEST(RasterPyramidTest, WhatIsUnchangedIsNotMadeAgain) {
  StoredGrid stored(0, 0, 2048, 2048);
  for (int column = 0; column < 2048; ++column) {
    for (int row = 0; row < 2048; ++row) stored.at(column, row) = kFree;
  }
  const RasterPyramid first = stored.Build();
  stored.loads = 0;
  stored.at(1500, 1500) = kWall;
  const RasterPyramid second = stored.Build(first.levels);
  EXPECT_EQ(second.made.size(), 3U);  // one at each of the zooms 1, 2 and 3
  EXPECT_LE(stored.loads, 12);
  StoredGrid fresh = stored;
  EXPECT_EQ(fresh.Build().levels, second.levels);
}

TEST(RasterPyramidTest, AThumbnailShowsTheWholeGrid) {
  StoredGrid stored(-100, 40, 1000, 300);
  for (int column = -100; column < 900; ++column) {
    for (int row = 40; row < 340; ++row) stored.at(column, row) = kFree;
  }
  stored.at(899, 339) = kWall;
  const RasterPyramid pyramid = stored.Build();
  ASSERT_OK_AND_ASSIGN(const Thumbnail thumbnail, MakeThumbnail(pyramid, stored.min(), 1000, 300, stored.load()));
  EXPECT_EQ(thumbnail.zoom, 4);
  EXPECT_EQ(thumbnail.width, 64);
  EXPECT_EQ(thumbnail.height, 20);
  EXPECT_EQ(thumbnail.lower_left, (CellIndex{-7, 2}));
  EXPECT_EQ(thumbnail.classes.front(), static_cast<std::uint8_t>(CellClass::kFree));
  EXPECT_EQ(thumbnail.classes.back(), static_cast<std::uint8_t>(CellClass::kOccupied));
}

TEST(RasterPyramidTest, DamagedTilesAreRefused) {
  StoredGrid stored(0, 0, 600, 600);
  stored.at(500, 500) = kWall;
  stored.at(0, 0) = kWall;
  const LoadTile damaged = [](std::string_view) -> absl::StatusOr<std::string> { return std::string("\1abc"); };
  RasterPyramid::Level tiles = stored.Build().levels.front();
  EXPECT_CODE(BuildPyramid(tiles, {}, damaged), absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace enfilade::grid
