// SPDX-License-Identifier: Apache-2.0
#include "core/grid/map_raster.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "core/grid/occupancy_values.h"
#include "tests/support/status_assertions.h"

namespace enfilade::grid {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

GridGeometry Row(int width) { return {.resolution = 0.05, .T_map_grid = {1, 2, 0.5}, .width = width, .height = 1}; }

std::uint8_t Cell(int value) { return CellFromOccupancyValue(static_cast<std::int8_t>(value)); }

TEST(MapRaster, ReadsGreysByTheirInterpretation) {
  MapRaster raster{Row(4), GreyCells{.grey = {0, 192, 205, 254}}};
  EXPECT_THAT(ToOccupancyGrid(raster).cells, ElementsAre(Cell(100), kUnknownCell, kUnknownCell, Cell(0)));
  EXPECT_EQ(ToOccupancyGrid(raster).geometry, raster.geometry);
  std::get<GreyCells>(raster.cells).interpretation.free_thresh = 0.25;
  EXPECT_THAT(ToOccupancyGrid(raster).cells, ElementsAre(Cell(100), Cell(0), Cell(0), Cell(0)));
}

TEST(MapRaster, ReadsAlpha) {
  const MapRaster raster{Row(3), GreyCells{.grey = {0, 0, 254}, .alpha = {255, 254, 0}}};
  EXPECT_THAT(ToOccupancyGrid(raster).cells, ElementsAre(Cell(100), kUnknownCell, kUnknownCell));
}

TEST(MapRaster, ReadsOtherWhites) {
  const MapRaster raster{Row(3), GreyCells{.grey = {0, 12, 15}, .max_value = 15}};
  EXPECT_THAT(ToOccupancyGrid(raster).cells, ElementsAre(Cell(100), kUnknownCell, Cell(0)));
}

TEST(MapRaster, TakesUnitsForProbabilities) {
  const MapRaster raster{Row(3), UnitCells{.values = {0.0, 0.5, 1.0}}};
  EXPECT_THAT(ToOccupancyGrid(raster).cells, ElementsAre(1, 128, 255));
}

TEST(MapRaster, RestoresAnOccupancyGrid) {
  const OccupancyGrid grid{Row(3), {0, 1, 255}};
  EXPECT_EQ(ToOccupancyGrid(FromOccupancyGrid(grid)), grid);
}

struct BadGeometry {
  GridGeometry geometry;
  const char* message;
};

void PrintTo(const BadGeometry& bad, std::ostream* os) { *os << bad.message; }

class BadGridGeometry : public ::testing::TestWithParam<BadGeometry> {};
INSTANTIATE_TEST_SUITE_P(MapRaster, BadGridGeometry,
                         ::testing::Values(BadGeometry{{0.0, {}, 1, 1}, "resolution is 0"},
                                           BadGeometry{{-0.1, {}, 1, 1}, "resolution is -0.1"},
                                           BadGeometry{{kNan, {}, 1, 1}, "resolution is nan"},
                                           BadGeometry{{kInfinity, {}, 1, 1}, "resolution is inf"},
                                           BadGeometry{{1.0, {kNan, 0, 0}, 1, 1}, "origin is [nan"},
                                           BadGeometry{{1.0, {0, kInfinity, 0}, 1, 1}, "origin is [0, inf"},
                                           BadGeometry{{1.0, {0, 0, kNan}, 1, 1}, "origin is [0, 0, nan"},
                                           BadGeometry{{1.0, {}, 0, 1}, "no cells"},
                                           BadGeometry{{1.0, {}, 1, 0}, "no cells"},
                                           BadGeometry{{1.0, {}, -1, -1}, "no cells"},
                                           BadGeometry{{1.0, {}, 100'000, 100'000}, "more than"},
                                           BadGeometry{{1.0, {}, INT32_MAX, INT32_MAX}, "more than"}));

TEST_P(BadGridGeometry, IsRefusedNamingTheField) {
  EXPECT_STATUS(Validate(GetParam().geometry), absl::StatusCode::kInvalidArgument, HasSubstr(GetParam().message));
}

TEST(MapRaster, RefusesCellsThatDoNotFitTheGeometry) {
  EXPECT_OK(Validate(MapRaster{Row(1), OccupancyCells{{0}}}));
  for (const MapRaster& raster :
       {MapRaster{Row(2), OccupancyCells{{0}}}, MapRaster{Row(2), GreyCells{.grey = {0}}},
        MapRaster{Row(2), GreyCells{.grey = {0, 0}, .alpha = {0}}}, MapRaster{Row(2), UnitCells{.values = {0.0}}}}) {
    EXPECT_STATUS(Validate(raster), absl::StatusCode::kInvalidArgument, HasSubstr("2 x 1 cells"));
  }
  EXPECT_STATUS(Validate(MapRaster{Row(1), GreyCells{.grey = {0}, .max_value = 0}}), absl::StatusCode::kInvalidArgument,
                HasSubstr("largest grey"));
}

}  // namespace
}  // namespace enfilade::grid
