// SPDX-License-Identifier: Apache-2.0
#include "core/grid/raster_header.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/support/status_assertions.h"

namespace enfilade::grid {
namespace {

using ::testing::HasSubstr;

RasterHeader RandomHeader(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  RasterHeader header;
  GridGeometry& geometry = header.raster.geometry;
  geometry.resolution = std::abs(normal(random)) + 1e-6;
  geometry.T_map_grid = {100.0 * normal(random), 100.0 * normal(random), normal(random)};
  geometry.width = 1 + static_cast<int>(random() % 10'000);
  geometry.height = 1 + static_cast<int>(random() % 10'000);
  header.lattice_min = {static_cast<int>(random() % 2'000'000) - 1'000'000, -static_cast<int>(random() % 1'000'000)};
  header.background = static_cast<std::uint8_t>(random());
  switch (random() % 3) {
    case 0:
      break;
    case 1:
      header.raster.cells =
          UnitCells{{}, {normal(random), normal(random), normal(random), 1.0 / 3.0, 0.1, 0.1, normal(random)}};
      break;
    default: {
      GreyCells cells;
      cells.max_value = 1 + static_cast<int>(random() % 255);
      cells.interpretation = {.mode = static_cast<MapMode>(random() % 3),
                              .dialect = static_cast<MapDialect>(random() % 2),
                              .negate = random() % 2 == 0,
                              .occupied_thresh = normal(random),
                              .free_thresh = normal(random)};
      cells.pgm_header = std::string(random() % 50, '#');
      cells.pgm_trailer = std::string(random() % 50, '\0');
      header.raster.cells = cells;
      header.has_alpha = random() % 2 == 0;
    }
  }
  return header;
}

class RasterHeaderRoundTrip : public ::testing::TestWithParam<unsigned> {};
INSTANTIATE_TEST_SUITE_P(Seeds, RasterHeaderRoundTrip, ::testing::Range(1U, 31U));

TEST_P(RasterHeaderRoundTrip, RestoresEveryField) {
  std::mt19937_64 random(GetParam());
  const RasterHeader header = RandomHeader(random);
  const std::string bytes = EncodeRasterHeader(header);
  EXPECT_EQ(EncodeRasterHeader(header), bytes);
  ASSERT_OK_AND_ASSIGN(const RasterHeader decoded, DecodeRasterHeader(bytes));
  EXPECT_TRUE(decoded.raster == header.raster);
  EXPECT_EQ(decoded.has_alpha, header.has_alpha);
  EXPECT_EQ(decoded.lattice_min, header.lattice_min);
  EXPECT_EQ(decoded.background, header.background);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_CODE(DecodeRasterHeader(bytes.substr(0, size)), absl::StatusCode::kDataLoss) << size;
  }
  EXPECT_CODE(DecodeRasterHeader(bytes + '\0'), absl::StatusCode::kDataLoss);
}

TEST(RasterHeader, RefusesInvalidContent) {
  const auto refused = [](const RasterHeader& header) {
    return DecodeRasterHeader(EncodeRasterHeader(header)).status();
  };
  RasterHeader good;
  good.raster.geometry = {.resolution = 0.05, .T_map_grid = {}, .width = 4, .height = 3};
  EXPECT_OK(refused(good));
  RasterHeader bad = good;
  bad.raster.geometry.resolution = std::nan("");
  EXPECT_STATUS(refused(bad), absl::StatusCode::kDataLoss, HasSubstr("resolution"));
  bad = good;
  bad.raster.geometry.T_map_grid.yaw = std::numeric_limits<double>::infinity();
  EXPECT_STATUS(refused(bad), absl::StatusCode::kDataLoss, HasSubstr("origin"));
  bad = good;
  bad.raster.geometry.width = -4;
  EXPECT_CODE(refused(bad), absl::StatusCode::kDataLoss);
  bad = good;
  bad.lattice_min.row = INT32_MIN;
  EXPECT_CODE(refused(bad), absl::StatusCode::kDataLoss);
  bad = good;
  bad.raster.cells = GreyCells{.max_value = 0};
  EXPECT_CODE(refused(bad), absl::StatusCode::kDataLoss);
  bad.raster.cells = GreyCells{.interpretation = {.mode = static_cast<MapMode>(3)}};
  EXPECT_CODE(refused(bad), absl::StatusCode::kDataLoss);
  bad.raster.cells = GreyCells{.interpretation = {.dialect = static_cast<MapDialect>(2)}};
  EXPECT_CODE(refused(bad), absl::StatusCode::kDataLoss);
}

TEST(RasterHeader, NamesANewerVersionAndForeignBytes) {
  RasterHeader header;
  header.raster.geometry = {.resolution = 0.05, .T_map_grid = {}, .width = 4, .height = 3};
  std::string bytes = EncodeRasterHeader(header);
  bytes[4] = 9;
  EXPECT_STATUS(DecodeRasterHeader(bytes), absl::StatusCode::kFailedPrecondition, HasSubstr("format 9"));
  bytes[4] = 0;
  EXPECT_CODE(DecodeRasterHeader(bytes), absl::StatusCode::kDataLoss);
  EXPECT_STATUS(DecodeRasterHeader("P5\n4 3\n255\n"), absl::StatusCode::kDataLoss, HasSubstr("not a raster's header"));
}

TEST(CellPlanes, ExposeTheCellsAsBytes) {
  MapRaster raster{{.resolution = 1, .T_map_grid = {}, .width = 2, .height = 1},
                   GreyCells{.grey = {7, 8}, .alpha = {9, 10}}};
  auto planes = PlanesOf(raster, 5);
  ASSERT_EQ(planes.size(), 2U);
  EXPECT_EQ(planes[0].bytes[1], 8);
  EXPECT_EQ(planes[0].background, 5);
  EXPECT_EQ(planes[1].bytes[0], 9);
  EXPECT_EQ(planes[1].background, 255) << "outside the image is opaque";
  planes[0].bytes[0] = 77;
  EXPECT_EQ(std::get<GreyCells>(raster.cells).grey[0], 77);
  MapRaster unit{raster.geometry, UnitCells{{0.25, 0.5}, {}}};
  ASSERT_EQ(PlanesOf(unit, 5).size(), 1U);
  EXPECT_EQ(PlanesOf(unit, 5)[0].element_size, sizeof(double));
  EXPECT_EQ(PlanesOf(unit, 5)[0].background, 0) << "0.0";
}

}  // namespace
}  // namespace enfilade::grid
