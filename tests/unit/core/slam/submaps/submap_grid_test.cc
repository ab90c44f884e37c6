// SPDX-License-Identifier: Apache-2.0
#include "core/slam/submaps/submap_grid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/status_assertions.h"

namespace enfilade::slam {
namespace {

constexpr double kCell = 0.1;  // m

// One beam along x, ending `range` (m) away.
grid::ScanRays Beam(double range) { return {{0.0, 0.05}, {{range, 0.05}}, {}}; }

SubmapGrid Simplified() {
  OccupancyOptions options;
  options.log_odds = false;
  return {kCell, options};
}

int ValueAt(const SubmapGrid& grid, double x) { return grid.log_odds().ValueAt(grid.log_odds().CellOf({x, 0.05})); }

TEST(SubmapGrid, AddsABeamByBresenhamInLogOdds) {
  SubmapGrid grid(kCell, {});
  ASSERT_OK(grid.Insert({}, Beam(0.55)).status());
  const OccupancyOptions options;
  const auto log_odds = [](double p) { return 1000.0 * std::log(p / (1.0 - p)); };
  EXPECT_NEAR(ValueAt(grid, 0.55), log_odds(options.hit_probability), 1.0);
  for (const double x : {0.05, 0.15, 0.25, 0.35, 0.45}) {
    EXPECT_NEAR(ValueAt(grid, x), log_odds(options.miss_probability), 1.0) << x;
  }
  EXPECT_EQ(ValueAt(grid, 0.65), grid::LogOddsGrid::kUnknown) << "behind the wall";
  EXPECT_TRUE(grid.IsOccupied(grid.log_odds().CellOf({0.55, 0.05})));
}

// +1 for a hit, -1 for a crossing beam, clamped at 10.
TEST(SubmapGrid, CountsUpAndDownInTheSimplifiedForm) {
  SubmapGrid grid = Simplified();
  ASSERT_OK(grid.Insert({}, Beam(0.55)).status());
  const int step = ValueAt(grid, 0.55);
  EXPECT_GT(step, 0);
  EXPECT_EQ(ValueAt(grid, 0.25), -step);
  ASSERT_OK(grid.Insert({}, Beam(0.85)).status());
  EXPECT_EQ(ValueAt(grid, 0.55), 0) << "one hit, one miss";
  EXPECT_EQ(ValueAt(grid, 0.25), -2 * step);
  for (int i = 0; i < 30; ++i) ASSERT_OK(grid.Insert({}, Beam(0.85)).status());
  EXPECT_NEAR(ValueAt(grid, 0.85), 10 * step, 10);
  EXPECT_NEAR(ValueAt(grid, 0.25), -10 * step, 10);
}

TEST(SubmapGrid, KeepsTheMeanOfTheHitsInACell) {
  SubmapGrid grid(kCell, {});
  for (const double range : {0.52, 0.54, 0.59}) ASSERT_OK(grid.Insert({}, Beam(range)).status());
  ASSERT_EQ(grid.OccupiedPoints().size(), 1U);
  EXPECT_NEAR(grid.OccupiedPoints()[0].x(), 0.55, 1e-12);
  EXPECT_NEAR(grid.OccupiedPoints()[0].y(), 0.05, 1e-12);
}

TEST(SubmapGrid, KeepsHitsByRowAndColumnWhateverTheirOrder) {
  SubmapGrid grid(kCell, {});
  const std::vector<std::vector<Eigen::Vector2d>> scans{{{2.05, 1.05}, {0.35, 0.25}, {2.01, 1.02}},
                                                        {{0.31, 0.29}, {1.05, 0.25}, {-0.55, 2.05}, {2.09, 1.02}}};
  for (const auto& hits : scans) ASSERT_OK(grid.Insert({}, {{0.0, 0.05}, hits, {}}).status());
  std::vector<SubmapGrid::Key> keys;
  std::vector<int> counts;
  for (const auto& [key, hit] : grid.hits()) {
    keys.push_back(key);
    counts.push_back(hit.count);
  }
  EXPECT_THAT(keys, ::testing::ElementsAre(SubmapGrid::Key(2, 3), SubmapGrid::Key(2, 10), SubmapGrid::Key(10, 20),
                                           SubmapGrid::Key(20, -6)));
  EXPECT_THAT(counts, ::testing::ElementsAre(2, 1, 3, 1));
  EXPECT_LT((grid.hits()[2].second.mean - Eigen::Vector2d(2.05, 1.03)).norm(), 1e-9);
}

TEST(SubmapGrid, SaysWhichCellsChangedAndForgetsWallsThatAreGone) {
  SubmapGrid grid(kCell, {});
  ASSERT_OK_AND_ASSIGN(const auto built, grid.Insert({}, Beam(0.55)));
  ASSERT_EQ(built.size(), 1U);
  EXPECT_EQ(built[0].column, 5);
  std::vector<grid::CellIndex> changed;
  while (grid.IsOccupied({5, 0})) {
    ASSERT_OK_AND_ASSIGN(changed, grid.Insert({}, Beam(0.95)));
  }
  const auto gone = [](const grid::CellIndex& cell) { return cell.column == 5; };
  EXPECT_TRUE(std::any_of(changed.begin(), changed.end(), gone)) << "the scan that freed it says so";
  ASSERT_EQ(grid.OccupiedPoints().size(), 1U);
  EXPECT_NEAR(grid.OccupiedPoints()[0].x(), 0.95, 1e-12);
}

TEST(SubmapGrid, IsReadBackExactlyAndRoundedWhereAsked) {
  SubmapGrid grid(kCell, {});
  for (const double range : {0.521, 0.543, 1.234567, 2.0})
    ASSERT_OK(grid.Insert({0.1, 0.2, 0.3}, Beam(range)).status());
  const auto read_back = [](const SubmapGrid& written) {
    std::string bytes;
    BinaryWriter writer(bytes);
    written.Serialize(writer);
    BinaryReader reader(bytes);
    return SubmapGrid::Deserialize(reader, {});
  };
  ASSERT_OK_AND_ASSIGN(const SubmapGrid same, read_back(grid));
  EXPECT_TRUE(same == grid);
  SubmapGrid rounded = grid;
  rounded.RoundMeans();
  ASSERT_OK_AND_ASSIGN(const SubmapGrid rounded_same, read_back(rounded));
  EXPECT_TRUE(rounded_same == rounded);
  const auto before = grid.OccupiedPoints();
  const auto after = rounded.OccupiedPoints();
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < after.size(); ++i) EXPECT_LT((after[i] - before[i]).norm(), 2e-4);
}

TEST(SubmapGrid, RefusesWhatItCannotHoldAndStaysAsItWas) {
  SubmapGrid grid(kCell, {});
  ASSERT_OK(grid.Insert({}, Beam(0.55)).status());
  const SubmapGrid before = grid;
  EXPECT_CODE(grid.Insert({}, Beam(1e8)).status(), absl::StatusCode::kResourceExhausted);
  // More than 200 MB of cells.
  EXPECT_CODE(grid.Insert({9e3 * kCell, 9e3 * kCell, 0.0}, Beam(1.0)).status(), absl::StatusCode::kResourceExhausted);
  EXPECT_CODE(grid.Insert({}, Beam(NAN)).status(), absl::StatusCode::kInvalidArgument);
  EXPECT_TRUE(grid == before);
}

TEST(SubmapGrid, RefusesDamagedBytes) {
  SubmapGrid grid(kCell, {});
  ASSERT_OK(grid.Insert({}, Beam(0.55)).status());
  std::string bytes;
  BinaryWriter writer(bytes);
  grid.Serialize(writer);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    BinaryReader reader(std::string_view(bytes).substr(0, size));
    EXPECT_CODE(SubmapGrid::Deserialize(reader, {}).status(), absl::StatusCode::kDataLoss) << size;
  }
}

}  // namespace
}  // namespace enfilade::slam
