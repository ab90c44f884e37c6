// SPDX-License-Identifier: Apache-2.0
#include "core/grid/log_odds_grid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <string>

#include "tests/support/status_assertions.h"

namespace enfilade::grid {
namespace {

using ::testing::HasSubstr;

constexpr double kLogOddsHit = 0.8473;    // ln(0.7 / 0.3)
constexpr double kLogOddsMiss = -0.4055;  // ln(0.4 / 0.6)

ScanRays RayTo(const Eigen::Vector2d& hit) { return {.origin = {0.5, 0.5}, .hits = {hit}, .free_ends = {}}; }

double LogOddsAt(const LogOddsGrid& grid, CellIndex cell) { return grid.ValueAt(cell) / LogOddsGrid::kUnitsPerLogOdds; }
double ProbabilityAt(const LogOddsGrid& grid, CellIndex cell) { return LogOddsGrid::ProbabilityOf(grid.ValueAt(cell)); }

// '.' unknown, ' ' free, '#' occupied; the top line is the highest row.
std::string Draw(const OccupancyGrid& grid) {
  std::string text;
  for (int row = grid.geometry.height - 1; row >= 0; --row) {
    for (int column = 0; column < grid.geometry.width; ++column) {
      const std::uint8_t cell = grid.cells[grid.geometry.index(column, row)];
      text += cell == kUnknownCell ? '.' : ProbabilityOfCell(cell) > 0.5 ? '#' : ' ';
    }
    text += '\n';
  }
  return text;
}

TEST(LogOddsGrid, RaisesTheHitAndLowersTheCellsBefore) {
  LogOddsGrid grid(1.0, {});
  ASSERT_OK(grid.Insert(RayTo({4.5, 0.5})));
  EXPECT_NEAR(LogOddsAt(grid, {4, 0}), kLogOddsHit, 1e-3);
  for (int column = 0; column < 4; ++column) EXPECT_NEAR(LogOddsAt(grid, {column, 0}), kLogOddsMiss, 1e-3);
  EXPECT_EQ(grid.ValueAt({5, 0}), LogOddsGrid::kUnknown);
  EXPECT_EQ(grid.ValueAt({2, 1}), LogOddsGrid::kUnknown);
  EXPECT_NEAR(ProbabilityAt(grid, {4, 0}), 0.7, 1e-3);
  EXPECT_EQ(ProbabilityAt(grid, {50, 50}), 0.5);
}

TEST(LogOddsGrid, FreeEndIsFree) {
  LogOddsGrid grid(1.0, {});
  ASSERT_OK(grid.Insert({.origin = {0.5, 0.5}, .hits = {}, .free_ends = {{3.5, 0.5}}}));
  EXPECT_NEAR(LogOddsAt(grid, {3, 0}), kLogOddsMiss, 1e-3);
}

TEST(LogOddsGrid, AddsUpAndStopsAtTheBounds) {
  LogOddsGrid grid(1.0, {});
  ASSERT_OK(grid.Insert(RayTo({2.5, 0.5})));
  ASSERT_OK(grid.Insert(RayTo({2.5, 0.5})));
  EXPECT_NEAR(LogOddsAt(grid, {2, 0}), 2 * kLogOddsHit, 2e-3);
  for (int i = 0; i < 50; ++i) ASSERT_OK(grid.Insert(RayTo({2.5, 0.5})));
  EXPECT_NEAR(ProbabilityAt(grid, {2, 0}), 0.971, 1e-3);
  EXPECT_NEAR(ProbabilityAt(grid, {1, 0}), 0.1192, 1e-3);
}

TEST(LogOddsGrid, EvenOddsAreNotUnknown) {
  LogOddsGrid grid(1.0, {.p_hit = 0.6, .p_miss = 0.4});
  ASSERT_OK(grid.Insert(RayTo({2.5, 0.5})));
  ASSERT_OK(grid.Insert(RayTo({3.5, 0.5})));  // passes through the cell that was hit
  EXPECT_EQ(grid.ValueAt({2, 0}), 0);
  EXPECT_EQ(ProbabilityOfCell(grid.ToOccupancyGrid().cells[2]), 0.5);
}

TEST(LogOddsGrid, ChangesEachCellOncePerScanAndLetsTheHitWin) {
  LogOddsGrid grid(1.0, {});
  // Two beams end in (4, 0), and a third passes through it.
  ASSERT_OK(grid.Insert({.origin = {0.5, 0.5}, .hits = {{4.2, 0.5}, {4.8, 0.5}, {8.5, 0.5}}, .free_ends = {}}));
  EXPECT_NEAR(LogOddsAt(grid, {4, 0}), kLogOddsHit, 1e-3);
  EXPECT_NEAR(LogOddsAt(grid, {1, 0}), kLogOddsMiss, 1e-3);
  EXPECT_NEAR(LogOddsAt(grid, {6, 0}), kLogOddsMiss, 1e-3);
}

TEST(LogOddsGrid, ChangesEachCellOncePerScanAfterHundredsOfScans) {
  LogOddsGrid grid(1.0, {.p_hit = 0.501, .p_miss = 0.499});
  for (int i = 1; i <= 600; ++i) {
    ASSERT_OK(grid.Insert(RayTo({2.5, 0.5})));
    ASSERT_EQ(grid.ValueAt({2, 0}), std::min(4 * i, 3511)) << "after scan " << i;
  }
}

TEST(LogOddsGrid, GrowsInAllDirectionsAndKeepsItsCells) {
  LogOddsGrid grid(0.5, {});
  ASSERT_OK(grid.Insert({.origin = {0.25, 0.25}, .hits = {{2.25, 0.25}}, .free_ends = {}}));
  for (const Eigen::Vector2d& far :
       {Eigen::Vector2d(-300.1, 0.3), Eigen::Vector2d(0.3, -200.1), Eigen::Vector2d(400.1, 150.1)}) {
    ASSERT_OK(grid.Insert({.origin = far, .hits = {far}, .free_ends = {}}));
    EXPECT_NEAR(LogOddsAt(grid, grid.CellOf(far)), kLogOddsHit, 1e-3);
  }
  EXPECT_NEAR(LogOddsAt(grid, {4, 0}), kLogOddsHit, 1e-3);
  EXPECT_NEAR(LogOddsAt(grid, {3, 0}), kLogOddsMiss, 1e-3);
  EXPECT_EQ(grid.CellOf({-300.1, 0.3}), (CellIndex{-601, 0}));
}

TEST(LogOddsGrid, DrawsARoom) {
  LogOddsGrid grid(1.0, {});
  ScanRays rays{.origin = {3.5, 2.5}, .hits = {}, .free_ends = {}};
  for (int column = 0; column <= 6; ++column) {
    rays.hits.push_back({column + 0.5, 0.5});
    rays.hits.push_back({column + 0.5, 4.5});
  }
  for (int row = 1; row <= 3; ++row) rays.hits.push_back({0.5, row + 0.5});
  rays.free_ends.push_back({6.5, 2.5});  // the door
  ASSERT_OK(grid.Insert(rays));
  EXPECT_EQ(Draw(grid.ToOccupancyGrid()),
            "#######\n"
            "#     .\n"
            "#      \n"
            "#     .\n"
            "#######\n");
}

TEST(LogOddsGrid, RendersTheKnownBoxInTheMapsFrame) {
  LogOddsGrid grid(0.5, {});
  ASSERT_OK(grid.Insert({.origin = {-2.75, 1.25}, .hits = {{-1.75, 1.75}}, .free_ends = {}}));
  const OccupancyGrid rendered = grid.ToOccupancyGrid();
  EXPECT_EQ(rendered.geometry,
            (GridGeometry{.resolution = 0.5, .T_map_grid = {-3.0, 1.0, 0.0}, .width = 3, .height = 2}));
  const OccupancyGrid moved = grid.ToOccupancyGrid({10.0, 0.0, M_PI / 2.0});
  EXPECT_NEAR(moved.geometry.T_map_grid.x, 9.0, 1e-12);
  EXPECT_NEAR(moved.geometry.T_map_grid.y, -3.0, 1e-12);
  EXPECT_EQ(moved.cells, rendered.cells);
}

TEST(LogOddsGrid, IsEmptyBeforeTheFirstScan) {
  LogOddsGrid grid(0.05, {});
  ASSERT_OK(grid.Insert({}));
  EXPECT_EQ(grid.ToOccupancyGrid().geometry.cell_count(), 0U);
  grid.Crop();
  EXPECT_TRUE(grid.cells().empty());
}

LogOddsGrid RandomDrive(unsigned seed) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> coordinate(-20.0, 20.0);
  LogOddsGrid grid(0.1, {});
  for (int i = 0; i < 20; ++i) {
    ScanRays rays{.origin = {coordinate(rng), coordinate(rng)}, .hits = {}, .free_ends = {}};
    for (int beam = 0; beam < 30; ++beam) rays.hits.push_back({coordinate(rng), coordinate(rng)});
    EXPECT_OK(grid.Insert(rays));
  }
  return grid;
}

TEST(LogOddsGrid, CropKeepsTheMapAndTakesMoreScans) {
  LogOddsGrid whole = RandomDrive(1);
  LogOddsGrid cropped = whole;
  cropped.Crop();
  EXPECT_LT(cropped.cells().size(), whole.cells().size());
  EXPECT_EQ(cropped.ToOccupancyGrid(), whole.ToOccupancyGrid());
  ASSERT_OK(whole.Insert(RayTo({30.0, 3.0})));
  ASSERT_OK(cropped.Insert(RayTo({30.0, 3.0})));
  EXPECT_EQ(cropped.ToOccupancyGrid(), whole.ToOccupancyGrid());
}

TEST(LogOddsGrid, ContinuesUnchangedAfterWriteAndRead) {
  LogOddsGrid grid = RandomDrive(2);
  std::string bytes;
  BinaryWriter writer(bytes);
  grid.Write(writer);
  BinaryReader reader(bytes);
  ASSERT_OK_AND_ASSIGN(LogOddsGrid restored, LogOddsGrid::Read(reader, {}));
  EXPECT_TRUE(reader.at_end());
  EXPECT_EQ(restored, grid);
  ASSERT_OK(grid.Insert(RayTo({30.0, 3.0})));
  ASSERT_OK(restored.Insert(RayTo({30.0, 3.0})));
  EXPECT_EQ(restored, grid);
}

TEST(LogOddsGrid, RefusesDamagedBytes) {
  const LogOddsGrid grid = RandomDrive(3);
  std::string bytes;
  BinaryWriter writer(bytes);
  grid.Write(writer);
  for (const std::size_t size : {std::size_t{0}, std::size_t{8}, std::size_t{30}, bytes.size() - 1}) {
    BinaryReader reader(std::string_view(bytes).substr(0, size));
    EXPECT_CODE(LogOddsGrid::Read(reader, {}), absl::StatusCode::kDataLoss) << size;
  }
  std::string negative_width = bytes;
  negative_width[19] = '\x80';
  BinaryReader reader(negative_width);
  EXPECT_CODE(LogOddsGrid::Read(reader, {}), absl::StatusCode::kDataLoss);
}

TEST(LogOddsGrid, RefusesRaysThatAreNotFiniteOrTooFar) {
  LogOddsGrid grid = RandomDrive(4);
  const LogOddsGrid before = grid;
  EXPECT_CODE(grid.Insert(RayTo({std::numeric_limits<double>::quiet_NaN(), 0.0})), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(grid.Insert(RayTo({0.0, -std::numeric_limits<double>::infinity()})), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(grid.Insert(RayTo({1e300, 0.0})), absl::StatusCode::kInvalidArgument);
  EXPECT_STATUS(grid.Insert(RayTo({1e6, 1e6})), absl::StatusCode::kResourceExhausted, HasSubstr("limit"));
  EXPECT_EQ(grid, before);
}

TEST(LogOddsOptions, NamesTheOptionThatIsWrong) {
  EXPECT_OK(LogOddsOptions{}.Validate());
  EXPECT_STATUS(LogOddsOptions{.p_hit = 0.5}.Validate(), absl::StatusCode::kInvalidArgument, HasSubstr("p_hit"));
  EXPECT_STATUS(LogOddsOptions{.p_miss = 0.5}.Validate(), absl::StatusCode::kInvalidArgument, HasSubstr("p_miss"));
  EXPECT_STATUS(LogOddsOptions{.p_min = 0.45}.Validate(), absl::StatusCode::kInvalidArgument, HasSubstr("p_min"));
  EXPECT_STATUS(LogOddsOptions{.p_max = 1.0}.Validate(), absl::StatusCode::kInvalidArgument, HasSubstr("p_max"));
  EXPECT_STATUS(LogOddsOptions{.max_cells = 0}.Validate(), absl::StatusCode::kInvalidArgument, HasSubstr("max_cells"));
}

}  // namespace
}  // namespace enfilade::grid
