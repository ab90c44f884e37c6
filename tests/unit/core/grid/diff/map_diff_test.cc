// SPDX-License-Identifier: Apache-2.0
#include "core/grid/diff/map_diff.h"

#include <gmock/gmock.h>

#include <cmath>
#include <deque>
#include <random>

#include "core/base/sha256.h"
#include "core/grid/diff/changed_runs.h"
#include "core/grid/tiled_raster.h"
#include "tests/support/status_assertions.h"

namespace enfilade::grid {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

constexpr std::uint8_t kFree = 20;
constexpr std::uint8_t kWall = 240;
constexpr std::uint8_t kUnsure = 128;
constexpr std::size_t kUnknownToOccupied = 2, kFreeToOccupied = 5, kOccupiedToFree = 7, kOccupiedToUnknown = 6,
                      kFreeToFree = 4;

// On the lattice of the map's frame, from the cell (column, row) on.
OccupancyGrid Free(int column, int row, int width, int height, double resolution = 0.05) {
  OccupancyGrid grid;
  grid.geometry = {resolution, {column * resolution, row * resolution, 0.0}, width, height};
  grid.cells.assign(grid.geometry.cell_count(), kFree);
  return grid;
}

void Draw(OccupancyGrid& grid, int column, int row, int width, int height, std::uint8_t value) {
  for (int y = row; y < row + height; ++y) {
    for (int x = column; x < column + width; ++x) grid.cells[grid.geometry.index(x, y)] = value;
  }
}

// Rasters as they are stored, which counts what is read.
class TileShelf {
 public:
  StoredTiles Store(const MapRaster& raster) {
    TiledRaster tiled = SplitIntoTiles(raster);
    StoredTiles stored{tiled.header, {}};
    for (auto& [index, bytes] : tiled.tiles) {
      const std::string sha256 = Sha256(bytes);
      stored.tiles.emplace(index, sha256);
      bytes_.emplace(sha256, std::move(bytes));
    }
    return stored;
  }
  LoadTiles load() {
    return [this](const std::vector<std::string>& sha256) {
      std::map<std::string, std::string> found;
      for (const std::string& digest : sha256) found.emplace(digest, bytes_.at(digest));
      reads += sha256.size();
      return found;
    };
  }
  std::size_t reads = 0;

 private:
  std::map<std::string, std::string> bytes_;
};

MapDiff Diff(const MapRaster& base, const MapRaster& revision, const MapDiffOptions& options = {}) {
  TileShelf shelf;
  auto diff = DiffTiles(shelf.Store(base), shelf.Store(revision), shelf.load(), options);
  EXPECT_OK(diff.status());
  return diff.ok() ? *std::move(diff) : MapDiff{};
}
MapDiff Diff(const OccupancyGrid& base, const OccupancyGrid& revision, const MapDiffOptions& options = {}) {
  return Diff(FromOccupancyGrid(base), FromOccupancyGrid(revision), options);
}

// What DiffTiles must tell, cell by cell: the changed cells of each group of touching ones, the largest first.
std::vector<std::int64_t> GroupsByFlooding(const OccupancyGrid& base, const OccupancyGrid& revision) {
  const auto classes = ClassesOfCells();
  const GridGeometry& geometry = base.geometry;
  std::vector<bool> left(geometry.cell_count());
  for (std::size_t i = 0; i < left.size(); ++i) left[i] = classes[base.cells[i]] != classes[revision.cells[i]];
  std::vector<std::int64_t> groups;
  for (int row = 0; row < geometry.height; ++row) {
    for (int column = 0; column < geometry.width; ++column) {
      if (!left[geometry.index(column, row)]) continue;
      left[geometry.index(column, row)] = false;
      std::int64_t cells = 0;
      std::deque<CellIndex> queue{{column, row}};
      for (; !queue.empty(); queue.pop_front(), ++cells) {
        for (int i = 0; i < 9; ++i) {
          const CellIndex next{queue.front().column + i % 3 - 1, queue.front().row + i / 3 - 1};
          if (!geometry.contains(next.column, next.row) || !left[geometry.index(next.column, next.row)]) continue;
          left[geometry.index(next.column, next.row)] = false;
          queue.push_back(next);
        }
      }
      groups.push_back(cells);
    }
  }
  std::sort(groups.begin(), groups.end(), std::greater<>());
  return groups;
}

TEST(MapDiffTest, CountsWhatEachCellWasAndIs) {
  const OccupancyGrid base = Free(0, 0, 600, 400);
  OccupancyGrid revision = base;
  Draw(revision, 250, 100, 12, 3, kWall);
  Draw(revision, 10, 10, 5, 5, kUnknownCell);
  Draw(revision, 500, 300, 2, 2, kUnsure);  // as unknown as what nobody has seen
  const MapDiff diff = Diff(base, revision);
  EXPECT_EQ(diff.resolution, 0.05);
  EXPECT_EQ(diff.cells[kFreeToOccupied], 36);
  EXPECT_EQ(diff.cells[3], 25 + 4);
  EXPECT_EQ(diff.cells[kFreeToFree], 600 * 400 - 36 - 29);
  EXPECT_EQ(diff.changed_cells(), 65);
  EXPECT_EQ(diff.region_count, 3);
  ASSERT_THAT(diff.regions, SizeIs(3));
  const MapDiffRegion& wall = diff.regions[0];
  EXPECT_EQ(wall.cells, 36);
  EXPECT_THAT(wall.to, ElementsAre(0, 0, 36));
  EXPECT_LT((wall.box[0] - Eigen::Vector2d(12.5, 5.0)).norm(), 1e-9);
  EXPECT_LT((wall.box[2] - Eigen::Vector2d(13.1, 5.15)).norm(), 1e-9);
  EXPECT_THAT(diff.regions[1].to, ElementsAre(25, 0, 0));
}

TEST(MapDiffTest, EqualRevisionsDoNotDiffer) {
  OccupancyGrid grid = Free(-300, -7, 600, 400);
  Draw(grid, 0, 0, 40, 1, kWall);
  const MapDiff diff = Diff(grid, grid, {.with_picture = true, .with_geojson = true});
  EXPECT_EQ(diff.changed_cells(), 0);
  EXPECT_EQ(diff.cells[8], 40);
  EXPECT_EQ(diff.region_count, 0);
  EXPECT_EQ(diff.geojson, "{\"type\":\"FeatureCollection\",\"features\":[]}\n");
}

TEST(MapDiffTest, TilesThatBothHaveAreReadOnce) {
  const OccupancyGrid base = Free(0, 0, 4 * kTileSize, 4 * kTileSize);
  OccupancyGrid revision = base;
  Draw(revision, 5, 5, 3, 3, kWall);
  TileShelf shelf;
  ASSERT_OK(
      DiffTiles(shelf.Store(FromOccupancyGrid(base)), shelf.Store(FromOccupancyGrid(revision)), shelf.load(), {}));
  EXPECT_EQ(shelf.reads, 2U) << "one that all have, and one that has changed";
}

TEST(MapDiffTest, WhatAGrownMapGainsWasUnknownBefore) {
  const OccupancyGrid base = Free(0, 0, 100, 100);
  OccupancyGrid revision = Free(-300, 0, 400, 150);
  Draw(revision, 0, 0, 1, 150, kWall);
  const MapDiff diff = Diff(base, revision);
  EXPECT_EQ(diff.cells[kUnknownToOccupied], 150);
  EXPECT_EQ(diff.cells[1], 400 * 150 - 100 * 100 - 150);
  EXPECT_EQ(diff.region_count, 1);
  EXPECT_LT((diff.regions.at(0).box[0] - Eigen::Vector2d(-15.0, 0.0)).norm(), 1e-9);
  const MapDiff back = Diff(revision, base);
  EXPECT_EQ(back.cells[kOccupiedToUnknown], 150);
  EXPECT_EQ(std::accumulate(back.cells.begin(), back.cells.end(), std::int64_t{0}), 400 * 150);
}

TEST(MapDiffTest, RegionsAreThoseOfAFloodFillWhateverTilesTheyCross) {
  std::mt19937 rng(5);
  for (const double share : {0.02, 0.3, 0.45, 0.9}) {
    OccupancyGrid base = Free(-200, 130, 300, 290);
    std::bernoulli_distribution changes(share);
    for (std::uint8_t& cell : base.cells) cell = rng() % 3 == 0 ? kWall : rng() % 2 == 0 ? kFree : kUnknownCell;
    OccupancyGrid revision = base;
    for (std::uint8_t& cell : revision.cells) {
      if (changes(rng)) cell = cell == kWall ? kFree : kWall;
    }
    const MapDiff diff = Diff(base, revision, {.max_regions = 1'000'000});
    std::vector<std::int64_t> sizes;
    for (const MapDiffRegion& region : diff.regions) {
      sizes.push_back(region.cells);
      EXPECT_EQ(region.to[0] + region.to[1] + region.to[2], region.cells);
    }
    EXPECT_EQ(sizes, GroupsByFlooding(base, revision)) << share;
    EXPECT_EQ(diff.region_count, static_cast<std::int64_t>(sizes.size()));
  }
}

TEST(MapDiffTest, StoredTilesAndRastersInMemoryGiveTheSame) {
  std::mt19937 rng(6);
  OccupancyGrid base = Free(-40, -40, 300, 300);
  OccupancyGrid revision = Free(-20, -60, 310, 280);
  for (std::uint8_t& cell : base.cells) cell = rng() % 7 == 0 ? kWall : kFree;
  for (std::uint8_t& cell : revision.cells) cell = rng() % 7 == 0 ? kWall : kFree;
  const MapDiffOptions options{.max_regions = 40, .with_picture = true, .with_geojson = true};
  const MapDiff stored = Diff(base, revision, options);
  ASSERT_OK_AND_ASSIGN(const MapDiff in_memory,
                       DiffRasters(FromOccupancyGrid(base), FromOccupancyGrid(revision), options));
  EXPECT_EQ(stored.cells, in_memory.cells);
  EXPECT_EQ(stored.geojson, in_memory.geojson);
  EXPECT_EQ(stored.picture->image.samples, in_memory.picture->image.samples);
  ASSERT_EQ(stored.regions.size(), in_memory.regions.size());
  for (std::size_t i = 0; i < stored.regions.size(); ++i) {
    EXPECT_LT((stored.regions[i].box[0] - in_memory.regions[i].box[0]).norm(), 1e-9);
  }
}

TEST(MapDiffTest, GreyImagesAreReadByTheirOwnThresholds) {
  MapRaster base;
  base.geometry = {0.05, {1.0, 2.0, 0.0}, 300, 20};
  GreyCells cells;
  cells.grey.assign(base.geometry.cell_count(), 205);  // unknown
  std::fill_n(cells.grey.begin(), 50, std::uint8_t{254});
  base.cells = cells;
  MapRaster revision = base;
  auto& changed = std::get<GreyCells>(revision.cells);
  changed.grey[0] = 0;
  EXPECT_EQ(Diff(base, revision).cells[kFreeToOccupied], 1);
  changed.interpretation.free_thresh = 0.25;  // 205 is free now, in all 6000 cells but 50
  const MapDiff diff = Diff(base, revision);
  EXPECT_EQ(diff.cells[1], 6000 - 50);
  EXPECT_EQ(diff.cells[0], 0) << "what lies outside the image does not count";
  EXPECT_EQ(diff.cells[kFreeToFree], 49);
}

TEST(MapDiffTest, OtherLatticesAreResampledToTheCoarserCells) {
  OccupancyGrid fine = Free(0, 0, 400, 400, 0.025);
  Draw(fine, 100, 100, 1, 200, kWall);
  OccupancyGrid coarse = Free(0, 0, 200, 200, 0.05);
  Draw(coarse, 50, 50, 1, 100, kWall);
  MapDiff diff = Diff(fine, coarse);
  EXPECT_EQ(diff.resolution, 0.05);
  EXPECT_EQ(diff.changed_cells(), 0) << "the wall of one fine cell is a wall of one coarse cell";
  EXPECT_EQ(diff.cells[8], 100);
  coarse.geometry.T_map_grid = {10.0, 0.0, M_PI / 2};  // turned about its corner: the same ground, another wall
  diff = Diff(fine, coarse);
  EXPECT_GT(diff.cells[kOccupiedToFree], 80);
  EXPECT_GT(diff.cells[kFreeToOccupied], 80);
}

TEST(MapDiffTest, CellsThatLieOnOneAnotherAreNotResampledWhereverTheyBegin) {
  OccupancyGrid base = Free(0, 0, 100, 50);
  base.geometry.T_map_grid = {0.013, -0.021, 0.3};
  OccupancyGrid revision = base;
  revision.geometry.T_map_grid = base.geometry.T_map_grid * Pose2{10 * 0.05, -4 * 0.05, 0.0};
  Draw(revision, 30, 30, 2, 2, kWall);
  const MapDiff diff = Diff(base, revision);
  EXPECT_EQ(diff.cells[kFreeToOccupied], 4);
  const Eigen::Vector2d corner = base.geometry.T_map_grid * Eigen::Vector2d(40 * 0.05, 26 * 0.05);
  EXPECT_LT((diff.regions.at(1).box[0] - corner).norm() * (diff.regions.at(0).box[0] - corner).norm(), 1e-9);
}

TEST(MapDiffTest, MapsThatAreTooFarApartAreRefused) {
  const OccupancyGrid base = Free(0, 0, 100, 100);
  for (const int away : {100'000, 500'000'000}) {
    EXPECT_STATUS(DiffRasters(FromOccupancyGrid(base), FromOccupancyGrid(Free(away, away, 100, 100)), {}),
                  absl::StatusCode::kFailedPrecondition, HasSubstr("far apart"));
  }
  TileShelf shelf;
  EXPECT_CODE(DiffTiles(shelf.Store(FromOccupancyGrid(base)),
                        shelf.Store(FromOccupancyGrid(Free(100'000, 100'000, 100, 100))), shelf.load(), {}),
              absl::StatusCode::kFailedPrecondition);
}

TEST(MapDiffTest, MapsWithoutAKnownCellAreEqual) {
  OccupancyGrid nothing = Free(0, 0, 30, 30, 0.05);
  OccupancyGrid coarser = Free(0, 0, 30, 30, 0.07);
  nothing.cells.assign(nothing.cells.size(), kUnknownCell);
  coarser.cells.assign(coarser.cells.size(), kUnknownCell);
  const MapDiff diff = Diff(nothing, coarser, {.with_picture = true});
  EXPECT_EQ(diff.changed_cells(), 0);
  EXPECT_OK(EncodePng(diff.picture->image));
}

TEST(MapDiffTest, OnlyTheLargestRegionsAreGiven) {
  const OccupancyGrid base = Free(0, 0, 300, 300);
  OccupancyGrid revision = base;
  for (int i = 1; i <= 20; ++i) Draw(revision, 10 * i, 10 * i, i % 7 + 1, 1, kWall);
  const MapDiff diff = Diff(base, revision, {.max_regions = 3, .with_geojson = true});
  EXPECT_EQ(diff.region_count, 20);
  ASSERT_THAT(diff.regions, SizeIs(3));
  EXPECT_EQ(diff.regions[0].cells, 7);
  EXPECT_LT(diff.regions[0].box[0].y(), diff.regions[1].box[0].y()) << "of equal ones the lowest first";
  EXPECT_THAT(diff.geojson, HasSubstr("\"cells\":7,"));
  EXPECT_EQ(std::count(diff.geojson.begin(), diff.geojson.end(), '\n'), 3);
}

Rgb PixelAt(const MapDiffPicture& picture, int column, int row_from_below) {
  const auto at =
      static_cast<std::size_t>(((picture.image.height - 1 - row_from_below) * picture.image.width + column) * 3);
  return {picture.image.samples[at], picture.image.samples[at + 1], picture.image.samples[at + 2]};
}

TEST(MapDiffTest, ThePictureShowsWhatCameAndWent) {
  OccupancyGrid base = Free(-10, 40, 300, 100);
  Draw(base, 100, 50, 10, 10, kWall);
  OccupancyGrid revision = base;
  Draw(revision, 100, 50, 10, 10, kFree);
  Draw(revision, 200, 70, 5, 5, kWall);
  Draw(revision, 0, 0, 5, 5, kUnknownCell);
  const MapDiff diff = Diff(base, revision, {.with_picture = true});
  const MapDiffPicture& picture = *diff.picture;
  EXPECT_EQ(picture.image.width, 300);
  EXPECT_EQ(picture.image.height, 100);
  EXPECT_EQ(PixelAt(picture, 104, 55), kRed);
  EXPECT_EQ(PixelAt(picture, 202, 72), kGreen);
  EXPECT_EQ(PixelAt(picture, 2, 2)[0], PixelAt(picture, 2, 2)[2] - 12) << "grey";
  EXPECT_EQ(PixelAt(picture, 250, 20), (Rgb{255, 255, 255}));
  EXPECT_NEAR(picture.T_map_picture.x, -0.5, 1e-9);
  EXPECT_NEAR(picture.T_map_picture.y, 2.0, 1e-9);
}

TEST(MapDiffTest, ALargePictureHasFewerPixelsAndLosesNoChange) {
  const OccupancyGrid base = Free(0, 0, 900, 300);
  OccupancyGrid revision = base;
  Draw(revision, 701, 133, 1, 1, kWall);
  const MapDiff diff = Diff(base, revision, {.with_picture = true, .max_picture_side = 256});
  EXPECT_EQ(diff.picture->cells_per_pixel, 4);
  EXPECT_EQ(diff.picture->image.width, 225);
  EXPECT_EQ(PixelAt(*diff.picture, 701 / 4, 133 / 4), kGreen);
}

TEST(ChangedRunsTest, RefusesToTellMoreThanMemoryPermits) {
  ChangedRuns runs;
  absl::Status status;
  for (int row = 0; status.ok() && row < 6000; ++row) {
    for (int column = 0; status.ok() && column < 4000; column += 2) {
      status = runs.Add({.row = row, .begin = column, .end = column + 1});
    }
  }
  EXPECT_STATUS(status, absl::StatusCode::kResourceExhausted, HasSubstr("differ in more than"));
}

}  // namespace
}  // namespace enfilade::grid
