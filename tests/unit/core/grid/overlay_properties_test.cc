// SPDX-License-Identifier: Apache-2.0
// Rules of overlays that hold for any grids, tried on random ones.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/grid/overlay.h"
#include "tests/support/status_assertions.h"

namespace enfilade::grid {
namespace {

constexpr double kLattice = 0.05;

OccupancyGrid RandomLayer(std::mt19937& random, int width, int height) {
  OccupancyGrid grid;
  grid.geometry = {.resolution = kLattice,
                   .T_map_grid = {(static_cast<int>(random() % 41) - 20) * kLattice,
                                  (static_cast<int>(random() % 41) - 20) * kLattice, 0.0},
                   .width = width,
                   .height = height};
  for (std::size_t i = 0; i < grid.geometry.cell_count(); ++i) {
    grid.cells.push_back(random() % 3 == 0 ? kUnknownCell : static_cast<std::uint8_t>(1 + random() % 255));
  }
  return grid;
}

CellIndex MinOf(const OccupancyGrid& grid) {
  return {static_cast<int>(std::lround(grid.geometry.T_map_grid.x / grid.geometry.resolution)),
          static_cast<int>(std::lround(grid.geometry.T_map_grid.y / grid.geometry.resolution))};
}

// Of a cell of the lattice; unknown outside the grid.
std::uint8_t CellAt(const OccupancyGrid& grid, int column, int row) {
  const CellIndex min = MinOf(grid);
  if (!grid.geometry.contains(column - min.column, row - min.row)) return kUnknownCell;
  return grid.cells[grid.geometry.index(column - min.column, row - min.row)];
}

TEST(OverlayOfCells, FollowsItsRulesForEveryPairOfValues) {
  for (int a = 0; a < 256; ++a) {
    for (int b = 0; b < 256; ++b) {
      const auto under = static_cast<std::uint8_t>(a);
      const auto over = static_cast<std::uint8_t>(b);
      const std::uint8_t result = Overlay(under, over);
      ASSERT_TRUE(result == under || result == over);
      ASSERT_EQ(result == kUnknownCell, a == 0 && b == 0) << "known if one is known";
      ASSERT_EQ(Overlay(result, over), result) << "the same layer again changes nothing";
      if (a == 0 || b == 0) continue;
      const bool disagree = (a < 128 && b > 128) || (a > 128 && b < 128);
      if (disagree) {
        ASSERT_EQ(result, over);
      } else {
        ASSERT_EQ(std::abs(result - 128), std::max(std::abs(a - 128), std::abs(b - 128))) << a << " " << b;
      }
    }
  }
}

TEST(OverlayOfGrids, IsTheOverlayOfTheirCells) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 100; ++trial) {
    const OccupancyGrid under =
        RandomLayer(random, 1 + static_cast<int>(random() % 20), 1 + static_cast<int>(random() % 20));
    const OccupancyGrid over =
        RandomLayer(random, 1 + static_cast<int>(random() % 20), 1 + static_cast<int>(random() % 20));
    ASSERT_OK_AND_ASSIGN(const OccupancyGrid both, Overlay(under, over));
    EXPECT_EQ(both.geometry.resolution, kLattice);
    for (int row = -25; row < 45; ++row) {
      for (int column = -25; column < 45; ++column) {
        ASSERT_EQ(CellAt(both, column, row), Overlay(CellAt(under, column, row), CellAt(over, column, row)))
            << trial << ": " << column << ", " << row;
      }
    }
    ASSERT_OK_AND_ASSIGN(const OccupancyGrid again, Overlay(both, over));
    EXPECT_EQ(again, both);
  }
}

OccupancyGrid OverlayAll(const OccupancyGrid& bottom, const std::vector<OccupancyGrid>& layers) {
  OccupancyGrid grid = bottom;
  for (const OccupancyGrid& layer : layers) grid = *Overlay(grid, layer);
  return grid;
}

LayerRun RunOf(const std::vector<OccupancyGrid>& layers) {
  LayerRun run;
  for (const OccupancyGrid& layer : layers) run = *Extend(run, layer);
  return run;
}

TEST(LayerRuns, LieOnAnyGridAsTheirLayersDo) {
  std::mt19937 random(5);
  const auto any = [&] { return RandomLayer(random, 1 + static_cast<int>(random() % 20), 15); };
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<OccupancyGrid> layers;
    for (unsigned n = 1 + random() % 6; n > 0; --n) layers.push_back(any());
    const LayerRun run = RunOf(layers);
    for (const OccupancyGrid& bottom : {OccupancyGrid{}, any()}) {
      ASSERT_EQ(OverlayAll(bottom, {run.reset, run.content}), OverlayAll(bottom, layers)) << trial;
    }
    const std::vector<OccupancyGrid> more = {any(), any()};
    const LayerRun longer = RunOf({run.reset, run.content, more[0], more[1]});  // a run of a run
    layers.insert(layers.end(), more.begin(), more.end());
    const OccupancyGrid bottom = any();
    ASSERT_EQ(OverlayAll(bottom, {longer.reset, longer.content}), OverlayAll(bottom, layers)) << trial;
  }
}

TEST(LayerRuns, HideWhatIsBelowOnlyWhereTheirLayersDisagree) {
  const auto cell = [](std::uint8_t value) {
    return OccupancyGrid{{.resolution = kLattice, .T_map_grid = {}, .width = 1, .height = 1}, {value}};
  };
  EXPECT_TRUE(RunOf({cell(200), cell(140)}).reset.cells.empty());
  EXPECT_EQ(RunOf({cell(100), cell(140)}).reset, cell(127));
  EXPECT_EQ(OverlayAll(cell(250), {cell(100), cell(140)}), cell(140)) << "not 250, the more certain one";
  EXPECT_EQ(Extend(LayerRun{}, cell(7))->content, cell(7));
}

TEST(ResampleToLatticeProperties, IsIdempotent) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int trial = 0; trial < 50; ++trial) {
    OccupancyGrid grid = RandomLayer(random, 12, 9);
    grid.geometry.resolution = 0.02 + 0.08 * std::abs(unit(random));
    grid.geometry.T_map_grid = {5.0 * unit(random), 5.0 * unit(random), M_PI * unit(random)};
    ASSERT_OK_AND_ASSIGN(const OccupancyGrid once, ResampleToLattice(grid, kLattice));
    ASSERT_OK_AND_ASSIGN(const OccupancyGrid twice, ResampleToLattice(once, kLattice));
    EXPECT_EQ(twice, once) << trial;
  }
}

TEST(ResampleToLatticeProperties, LosesNoOccupiedCellAtAnyPose) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int trial = 0; trial < 50; ++trial) {
    OccupancyGrid grid = RandomLayer(random, 15, 11);
    grid.geometry.resolution = 0.01 + 0.04 * std::abs(unit(random));  // finer than the lattice
    grid.geometry.T_map_grid = {3.0 * unit(random), 3.0 * unit(random), M_PI * unit(random)};
    ASSERT_OK_AND_ASSIGN(const OccupancyGrid result, ResampleToLattice(grid, kLattice));
    for (int row = 0; row < grid.geometry.height; ++row) {
      for (int column = 0; column < grid.geometry.width; ++column) {
        const std::uint8_t value = grid.cells[grid.geometry.index(column, row)];
        if (value <= 128) continue;
        const Eigen::Vector2d p = grid.geometry.T_map_grid * Eigen::Vector2d((column + 0.5) * grid.geometry.resolution,
                                                                             (row + 0.5) * grid.geometry.resolution);
        EXPECT_GE(CellAt(result, static_cast<int>(std::floor(p.x() / kLattice)),
                         static_cast<int>(std::floor(p.y() / kLattice))),
                  value);
      }
    }
  }
}

TEST(ResampleToLatticeProperties, CropsToTheKnownCells) {
  std::mt19937 random(4);
  for (int trial = 0; trial < 50; ++trial) {
    OccupancyGrid grid = RandomLayer(random, 10, 10);
    for (std::uint8_t& cell : grid.cells) cell = random() % 40 == 0 ? cell : kUnknownCell;
    ASSERT_OK_AND_ASSIGN(const OccupancyGrid cropped, ResampleToLattice(grid, kLattice));
    const auto known = [](std::uint8_t cell) { return cell != kUnknownCell; };
    EXPECT_EQ(std::count_if(cropped.cells.begin(), cropped.cells.end(), known),
              std::count_if(grid.cells.begin(), grid.cells.end(), known));
    if (cropped.cells.empty()) continue;
    const auto row_has_known = [&](int row) {
      const auto begin = cropped.cells.begin() + static_cast<std::ptrdiff_t>(cropped.geometry.index(0, row));
      return std::any_of(begin, begin + cropped.geometry.width, known);
    };
    EXPECT_TRUE(row_has_known(0));
    EXPECT_TRUE(row_has_known(cropped.geometry.height - 1));
  }
}

}  // namespace
}  // namespace enfilade::grid
