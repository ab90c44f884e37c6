// SPDX-License-Identifier: Apache-2.0
#include "core/grid/tiled_raster.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <ostream>
#include <random>
#include <set>
#include <string>

#include "tests/support/status_assertions.h"

namespace enfilade::grid {

void PrintTo(const MapRaster& raster, std::ostream* os) {
  *os << "cells of kind " << raster.cells.index() << ", " << raster.geometry.width << " x " << raster.geometry.height;
}

namespace {

using ::testing::HasSubstr;

// Values in [low, high], in patches so that they compress.
template <typename T>
std::vector<T> Patches(std::size_t count, T low, T high, unsigned seed) {
  std::mt19937 rng(seed);
  std::vector<T> values;
  while (values.size() < count) {
    const double share = static_cast<double>(rng()) / 4294967295.0;
    values.insert(values.end(), std::min<std::size_t>(count - values.size(), 1 + rng() % 50),
                  static_cast<T>(low + share * (high - low)));
  }
  return values;
}

absl::StatusOr<MapRaster> Assemble(const TiledRaster& tiled) {
  absl::StatusOr<RasterAssembler> assembler = RasterAssembler::Create(tiled.header);
  if (!assembler.ok()) return assembler.status();
  for (const auto& [index, bytes] : tiled.tiles) {
    if (const absl::Status status = assembler->Add(index, bytes); !status.ok()) return status;
  }
  return (*std::move(assembler)).Finish();
}

GridGeometry GeometryAt(int column, int row, int width, int height) {
  return {.resolution = 0.05, .T_map_grid = {column * 0.05, row * 0.05, 0.0}, .width = width, .height = height};
}

MapRaster OccupancyRaster(const GridGeometry& geometry) {
  return {geometry, OccupancyCells{Patches<std::uint8_t>(geometry.cell_count(), 0, 255, 1)}};
}

MapRaster GreyRaster(const GridGeometry& geometry, bool with_alpha) {
  GreyCells cells{.grey = Patches<std::uint8_t>(geometry.cell_count(), 0, 255, 2), .max_value = 255};
  if (with_alpha) cells.alpha = Patches<std::uint8_t>(geometry.cell_count(), 0, 255, 3);
  cells.interpretation = {.mode = MapMode::kScale,
                          .dialect = MapDialect::kRos1,
                          .negate = true,
                          .occupied_thresh = 0.7,
                          .free_thresh = 0.1};
  cells.pgm_header = "P5\n# x\n";
  cells.pgm_trailer = std::string("\0\n", 2);
  return {geometry, cells};
}

MapRaster UnitRaster(const GridGeometry& geometry) {
  return {geometry, UnitCells{Patches<double>(geometry.cell_count(), 0.0, 1.0, 4), {-1, 2, -3, 4, 0.5, 0.6, 20}}};
}

class EveryRaster : public ::testing::TestWithParam<MapRaster> {};
INSTANTIATE_TEST_SUITE_P(
    TiledRaster, EveryRaster,
    ::testing::Values(OccupancyRaster(GeometryAt(-700, 130, 1000, 300)), OccupancyRaster(GeometryAt(0, 0, 256, 256)),
                      OccupancyRaster(GeometryAt(255, -257, 2, 2)), OccupancyRaster(GeometryAt(3, 3, 1, 1)),
                      GreyRaster(GeometryAt(-700, 130, 600, 300), false), GreyRaster(GeometryAt(0, 0, 513, 100), true),
                      UnitRaster(GeometryAt(10, 10, 401, 401))));

TEST_P(EveryRaster, IsRestoredUnchanged) {
  const TiledRaster tiled = SplitIntoTiles(GetParam());
  ASSERT_OK_AND_ASSIGN(const MapRaster joined, Assemble(tiled));
  EXPECT_EQ(joined, GetParam());
}

TEST_P(EveryRaster, IsDeterministic) { EXPECT_EQ(SplitIntoTiles(GetParam()), SplitIntoTiles(GetParam())); }

TEST_P(EveryRaster, RefusesDamagedTiles) {
  TiledRaster tiled = SplitIntoTiles(GetParam());
  std::string& bytes = tiled.tiles.begin()->second;
  std::mt19937 rng(6);
  int refused = 0;
  for (int i = 0; i < 100; ++i) {
    const std::string before = bytes;
    bytes[rng() % bytes.size()] ^= static_cast<char>(1 + rng() % 255);
    // Zstandard has a bit or two that mean nothing; all others are under its checksum.
    const auto joined = Assemble(tiled);
    EXPECT_TRUE(!joined.ok() || *joined == GetParam());
    refused += joined.ok() ? 0 : 1;
    bytes = before.substr(0, rng() % before.size());
    EXPECT_FALSE(Assemble(tiled).ok());
    bytes = before;
  }
  EXPECT_GT(refused, 90);
}

TEST_P(EveryRaster, NeverFailsOnADamagedHeaderInAnyOtherWayThanAnError) {
  const std::string header = SplitIntoTiles(GetParam()).header;
  for (std::size_t size = 0; size < header.size(); ++size) {
    EXPECT_CODE(DecodeRasterHeader(header.substr(0, size)), absl::StatusCode::kDataLoss);
  }
  for (std::size_t i = 0; i < header.size() * 8; ++i) {
    std::string damaged = header;
    damaged[i / 8] = static_cast<char>(damaged[i / 8] ^ (1 << (i % 8)));
    (void)DecodeRasterHeader(damaged);
  }
}

TEST(TiledRaster, AnchorsOurGridsAtTheMapsOrigin) {
  const TiledRaster tiled = SplitIntoTiles(OccupancyRaster(GeometryAt(-300, 200, 310, 60)));
  std::set<TileIndex> indices;
  for (const auto& [index, bytes] : tiled.tiles) indices.insert(index);
  EXPECT_EQ(indices, (std::set<TileIndex>{{0, -2}, {0, -1}, {0, 0}, {1, -2}, {1, -1}, {1, 0}}));
}

TEST(TiledRaster, AnchorsImportsAtTheirCorner) {
  EXPECT_EQ(SplitIntoTiles(GreyRaster(GeometryAt(-300, 200, 310, 60), false)).tiles.begin()->first, (TileIndex{0, 0}));
  GridGeometry between = GeometryAt(-300, 200, 10, 10);
  between.T_map_grid.x += 0.02;
  EXPECT_EQ(SplitIntoTiles(OccupancyRaster(between)).tiles.begin()->first, (TileIndex{0, 0}));
  GridGeometry rotated = GeometryAt(-300, 200, 10, 10);
  rotated.T_map_grid.yaw = 0.1;
  EXPECT_EQ(SplitIntoTiles(OccupancyRaster(rotated)).tiles.begin()->first, (TileIndex{0, 0}));
}

TEST(TiledRaster, KeepsUnchangedTilesAsTheMapGrows) {
  const MapRaster small = OccupancyRaster(GeometryAt(-100, -50, 500, 400));
  // The same cells within a larger grid, with something new far to the lower left.
  MapRaster large{GeometryAt(-700, -333, 1300, 1000), OccupancyCells{}};
  auto& cells = std::get<OccupancyCells>(large.cells).values;
  cells.assign(large.geometry.cell_count(), kUnknownCell);
  for (int row = 0; row < small.geometry.height; ++row) {
    for (int column = 0; column < small.geometry.width; ++column) {
      cells[large.geometry.index(column + 600, row + 283)] =
          std::get<OccupancyCells>(small.cells).values[small.geometry.index(column, row)];
    }
  }
  cells[0] = 77;
  const TiledRaster before = SplitIntoTiles(small);
  TiledRaster after = SplitIntoTiles(large);
  EXPECT_EQ(after.tiles.erase({-2, -3}), 1U);
  EXPECT_EQ(after.tiles, before.tiles);
}

TEST(TiledRaster, LeavesOutTilesOfBackground) {
  MapRaster raster{GeometryAt(0, 0, 2560, 2560), OccupancyCells{}};
  auto& cells = std::get<OccupancyCells>(raster.cells).values;
  cells.assign(raster.geometry.cell_count(), kUnknownCell);
  cells[raster.geometry.index(1000, 300)] = 1;
  const TiledRaster tiled = SplitIntoTiles(raster);
  ASSERT_EQ(tiled.tiles.size(), 1U);
  EXPECT_EQ(tiled.tiles.begin()->first, (TileIndex{1, 3}));
  EXPECT_LT(tiled.tiles.begin()->second.size(), 100U);
  ASSERT_OK_AND_ASSIGN(const MapRaster joined, Assemble(tiled));
  EXPECT_EQ(joined, raster);
}

TEST(TiledRaster, TakesTheMostFrequentGreyForBackground) {
  MapRaster raster{GeometryAt(0, 0, 1000, 1000), GreyCells{}};
  auto& grey = std::get<GreyCells>(raster.cells);
  grey.grey.assign(raster.geometry.cell_count(), 205);
  grey.grey[0] = 0;
  const TiledRaster tiled = SplitIntoTiles(raster);
  EXPECT_EQ(tiled.tiles.size(), 1U);
  ASSERT_OK_AND_ASSIGN(const MapRaster joined, Assemble(tiled));
  EXPECT_EQ(joined, raster);
}

TEST(TiledRaster, RefusesTilesOutsideTheRaster) {
  TiledRaster tiled = SplitIntoTiles(OccupancyRaster(GeometryAt(0, 0, 300, 300)));
  const std::string bytes = tiled.tiles.begin()->second;
  ASSERT_OK_AND_ASSIGN(RasterAssembler assembler, RasterAssembler::Create(tiled.header));
  for (const TileIndex index : {TileIndex{0, 2}, TileIndex{-1, 0}, TileIndex{INT32_MAX, INT32_MIN}}) {
    EXPECT_STATUS(assembler.Add(index, bytes), absl::StatusCode::kDataLoss, HasSubstr("outside"));
  }
}

TEST(TiledRaster, NamesANewerFormatVersion) {
  TiledRaster tiled = SplitIntoTiles(OccupancyRaster(GeometryAt(0, 0, 30, 30)));
  tiled.tiles.begin()->second[0] = 2;
  EXPECT_STATUS(Assemble(tiled), absl::StatusCode::kFailedPrecondition, HasSubstr("newer release"));
  tiled.header[4] = 2;
  EXPECT_STATUS(Assemble(tiled), absl::StatusCode::kFailedPrecondition, HasSubstr("newer release"));
}

TEST(TiledRaster, RefusesHugeHeadersBeforeAllocating) {
  RasterHeader header;
  header.raster.geometry = GeometryAt(0, 0, 100'000, 100'000);
  EXPECT_STATUS(RasterAssembler::Create(EncodeRasterHeader(header)), absl::StatusCode::kDataLoss,
                HasSubstr("more than"));
}

}  // namespace
}  // namespace enfilade::grid
