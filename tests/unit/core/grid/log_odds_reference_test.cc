// SPDX-License-Identifier: Apache-2.0
// LogOddsGrid against a plain implementation of the same rules: a map from cells to values.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <set>

#include "core/grid/log_odds_grid.h"
#include "tests/support/status_assertions.h"

namespace enfilade::grid {
namespace {

using ColumnRow = std::pair<int, int>;  // column, row

class ReferenceGrid {
 public:
  ReferenceGrid(double resolution, const LogOddsOptions& options) : resolution_(resolution), options_(options) {}

  void Insert(const ScanRays& rays) {
    std::set<ColumnRow> changed;
    for (const Eigen::Vector2d& hit : rays.hits) {
      if (changed.insert(CellOf(hit)).second) Add(CellOf(hit), options_.p_hit);
    }
    for (const std::vector<Eigen::Vector2d>* ends : {&rays.hits, &rays.free_ends}) {
      for (const Eigen::Vector2d& end : *ends) {
        const ColumnRow from = CellOf(rays.origin);
        const ColumnRow to = CellOf(end);
        VisitLine({from.first, from.second}, {to.first, to.second}, [&](CellIndex cell) {
          if (changed.insert({cell.column, cell.row}).second) Add({cell.column, cell.row}, options_.p_miss);
        });
      }
    }
  }

  const std::map<ColumnRow, int>& cells() const { return cells_; }

 private:
  static int Units(double p) { return static_cast<int>(std::lround(1000.0 * std::log(p / (1.0 - p)))); }
  ColumnRow CellOf(const Eigen::Vector2d& p) const {
    return {static_cast<int>(std::floor(p.x() / resolution_)), static_cast<int>(std::floor(p.y() / resolution_))};
  }
  void Add(ColumnRow cell, double p) {
    int& value = cells_[cell];
    value = std::clamp(value + Units(p), Units(options_.p_min), Units(options_.p_max));
  }

  double resolution_;
  LogOddsOptions options_;
  std::map<ColumnRow, int> cells_;
};

ScanRays RandomScan(std::mt19937& random, double reach) {
  std::uniform_real_distribution<double> at(-reach, reach);
  ScanRays rays{.origin = {at(random), at(random)}, .hits = {}, .free_ends = {}};
  for (std::uint32_t beams = random() % 25; beams > 0; --beams) rays.hits.emplace_back(at(random), at(random));
  for (std::uint32_t beams = random() % 8; beams > 0; --beams) rays.free_ends.emplace_back(at(random), at(random));
  if (random() % 3 == 0) rays.hits.push_back(rays.origin);  // a beam that ends in the robot's own cell
  return rays;
}

class LogOddsReference : public ::testing::TestWithParam<unsigned> {};
INSTANTIATE_TEST_SUITE_P(Seeds, LogOddsReference, ::testing::Range(1U, 13U));

TEST_P(LogOddsReference, GivesTheSameCells) {
  std::mt19937 random(GetParam());
  const LogOddsOptions options{.p_hit = 0.55 + 0.03 * (GetParam() % 10), .p_miss = 0.45 - 0.02 * (GetParam() % 10)};
  LogOddsGrid grid(0.25, options);
  ReferenceGrid reference(0.25, options);
  for (int scan = 0; scan < 40; ++scan) {
    const ScanRays rays = RandomScan(random, 1.0 + scan * 0.5);
    ASSERT_OK(grid.Insert(rays));
    reference.Insert(rays);
    if (scan == 20) grid.Crop();  // must not change what follows
  }
  std::size_t known = 0;
  for (const std::int16_t value : grid.cells()) known += value == LogOddsGrid::kUnknown ? 0 : 1;
  EXPECT_EQ(known, reference.cells().size());
  for (const auto& [cell, value] : reference.cells()) {
    ASSERT_EQ(grid.ValueAt({cell.first, cell.second}), value) << cell.first << ", " << cell.second;
  }
}

TEST_P(LogOddsReference, RendersTheReferencesProbabilities) {
  std::mt19937 random(GetParam() + 100);
  LogOddsGrid grid(0.5, {});
  ReferenceGrid reference(0.5, {});
  for (int scan = 0; scan < 10; ++scan) {
    const ScanRays rays = RandomScan(random, 10.0);
    ASSERT_OK(grid.Insert(rays));
    reference.Insert(rays);
  }
  const OccupancyGrid rendered = grid.ToOccupancyGrid();
  const int left = static_cast<int>(std::lround(rendered.geometry.T_map_grid.x / 0.5));
  const int bottom = static_cast<int>(std::lround(rendered.geometry.T_map_grid.y / 0.5));
  for (int row = 0; row < rendered.geometry.height; ++row) {
    for (int column = 0; column < rendered.geometry.width; ++column) {
      const std::uint8_t cell = rendered.cells[rendered.geometry.index(column, row)];
      const auto found = reference.cells().find({left + column, bottom + row});
      if (found == reference.cells().end()) {
        ASSERT_EQ(cell, kUnknownCell);
      } else {
        ASSERT_NEAR(ProbabilityOfCell(cell), 1.0 / (1.0 + std::exp(-found->second / 1000.0)), 0.5 / 254.0);
      }
    }
  }
}

TEST(LogOddsWindow, TakesCellsAndClampsThem) {
  const std::vector<std::int16_t> cells = {0, 30'000, -30'000, LogOddsGrid::kUnknown, 500, -500};
  ASSERT_OK_AND_ASSIGN(const LogOddsGrid grid, LogOddsGrid::FromWindow(0.1, {}, {{-1, 5}, 3, 2, cells}));
  EXPECT_EQ(grid.ValueAt({-1, 5}), 0);
  EXPECT_NEAR(LogOddsGrid::ProbabilityOf(grid.ValueAt({0, 5})), 0.971, 1e-3);
  EXPECT_NEAR(LogOddsGrid::ProbabilityOf(grid.ValueAt({1, 5})), 0.1192, 1e-3);
  EXPECT_EQ(grid.ValueAt({-1, 6}), LogOddsGrid::kUnknown);
  EXPECT_EQ(grid.ValueAt({0, 6}), 500);
  EXPECT_EQ(grid.ValueAt({1, 7}), LogOddsGrid::kUnknown) << "outside the window";
}

TEST(LogOddsWindow, RefusesAnotherNumberOfCells) {
  EXPECT_CODE(LogOddsGrid::FromWindow(0.1, {}, {{0, 0}, 2, 2, {1, 2, 3}}), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(LogOddsGrid::FromWindow(0.1, {}, {{0, 0}, -1, -3, {1, 2, 3}}), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(LogOddsGrid::FromWindow(0.1, {}, {{0, 0}, 1 << 30, 4, {}}), absl::StatusCode::kInvalidArgument);
}

TEST(LogOddsWindow, ReadRefusesValuesBeyondTheOptions) {
  ASSERT_OK_AND_ASSIGN(const LogOddsGrid grid, LogOddsGrid::FromWindow(0.1, {}, {{0, 0}, 1, 1, {3000}}));
  std::string bytes;
  BinaryWriter writer(bytes);
  grid.Write(writer);
  BinaryReader same(bytes);
  EXPECT_OK(LogOddsGrid::Read(same, {}));
  BinaryReader narrower(bytes);
  EXPECT_STATUS(LogOddsGrid::Read(narrower, {.p_max = 0.9}), absl::StatusCode::kDataLoss,
                ::testing::HasSubstr("beyond the bounds"));
}

}  // namespace
}  // namespace enfilade::grid
