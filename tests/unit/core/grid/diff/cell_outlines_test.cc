// SPDX-License-Identifier: Apache-2.0
#include "core/grid/diff/cell_outlines.h"

#include <gmock/gmock.h>

#include <random>
#include <string>

#include "core/grid/diff/map_diff.h"
#include "nlohmann/json.hpp"
#include "tests/support/status_assertions.h"

namespace enfilade::grid {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// Of a drawing whose last line is row 0: '#' is a cell.
std::vector<ChangedRun> RunsOf(const std::vector<std::string>& drawing) {
  std::vector<ChangedRun> runs;
  for (int row = 0; row < static_cast<int>(drawing.size()); ++row) {
    const std::string& line = drawing[drawing.size() - 1 - static_cast<std::size_t>(row)];
    for (int column = 0; column < static_cast<int>(line.size()); ++column) {
      if (line[static_cast<std::size_t>(column)] != '#') continue;
      if (!runs.empty() && runs.back().row == row && runs.back().end == column) {
        ++runs.back().end;
      } else {
        runs.push_back({.row = row, .begin = column, .end = column + 1});
      }
    }
  }
  return runs;
}

double AreaOf(const CellRing& ring) {
  double area = 0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const CellIndex& a = ring[i];
    const CellIndex& b = ring[(i + 1) % ring.size()];
    area += 0.5 * (static_cast<double>(a.column) * b.row - static_cast<double>(b.column) * a.row);
  }
  return area;
}

// Whether the middle of a cell is in the ring (even-odd rule).
bool IsInside(const CellRing& ring, int column, int row) {
  bool inside = false;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const CellIndex& a = ring[i];
    const CellIndex& b = ring[(i + 1) % ring.size()];
    if (a.column != b.column || std::min(a.row, b.row) > row || std::max(a.row, b.row) <= row) continue;
    if (a.column > column) inside = !inside;
  }
  return inside;
}

TEST(CellOutlinesTest, ABlockHasFourCorners) {
  const auto polygons = OutlinesOf(RunsOf({"###", "###"}));
  ASSERT_THAT(polygons, SizeIs(1));
  EXPECT_THAT(polygons[0].outer, SizeIs(4));
  EXPECT_EQ(AreaOf(polygons[0].outer), 6.0) << "counter-clockwise";
  EXPECT_THAT(polygons[0].holes, IsEmpty());
}

TEST(CellOutlinesTest, AHoleIsARingOfItsOwn) {
  const auto polygons = OutlinesOf(RunsOf({"#####", "#...#", "#.#.#", "#...#", "#####"}));
  ASSERT_THAT(polygons, SizeIs(2)) << "the cell within the hole touches nothing";
  EXPECT_EQ(AreaOf(polygons[0].outer), 25.0);
  ASSERT_THAT(polygons[0].holes, SizeIs(1));
  EXPECT_EQ(AreaOf(polygons[0].holes[0]), -9.0) << "clockwise";
  EXPECT_EQ(AreaOf(polygons[1].outer), 1.0);
}

TEST(CellOutlinesTest, CellsThatTouchAtACornerAreApart) {
  const auto polygons = OutlinesOf(RunsOf({"#.#", ".#.", "#.#"}));
  ASSERT_THAT(polygons, SizeIs(5));
  for (const CellPolygon& polygon : polygons) EXPECT_EQ(AreaOf(polygon.outer), 1.0);
}

TEST(CellOutlinesTest, HolesThatTouchAtACornerAreOneRingEach) {
  const auto polygons = OutlinesOf(RunsOf({"####", "#.##", "##.#", "####"}));
  ASSERT_THAT(polygons, SizeIs(1));
  double holes = 0;
  for (const CellRing& hole : polygons[0].holes) holes += AreaOf(hole);
  EXPECT_EQ(holes, -2.0);
}

TEST(CellOutlinesTest, OutlinesHoldExactlyTheCells) {
  std::mt19937 rng(3);
  for (int round = 0; round < 40; ++round) {
    std::vector<std::string> drawing(12, std::string(15, '.'));
    for (std::string& line : drawing) {
      for (char& cell : line) cell = rng() % 10 < static_cast<unsigned>(2 + round % 7) ? '#' : '.';
    }
    const auto polygons = OutlinesOf(RunsOf(drawing));
    for (int row = 0; row < 12; ++row) {
      for (int column = 0; column < 15; ++column) {
        int times = 0;
        for (const CellPolygon& polygon : polygons) {
          bool in_hole = false;
          for (const CellRing& hole : polygon.holes) in_hole = in_hole || IsInside(hole, column, row);
          times += IsInside(polygon.outer, column, row) && !in_hole ? 1 : 0;
        }
        const char drawn = drawing[static_cast<std::size_t>(11 - row)][static_cast<std::size_t>(column)];
        ASSERT_EQ(times, drawn == '#' ? 1 : 0) << "round " << round << ", cell " << column << ", " << row;
      }
    }
  }
}

TEST(MapDiffGeoJsonTest, WhatCameAndWentAreFeaturesInTheMapsFrame) {
  OccupancyGrid base;
  base.geometry = {0.1, {-1.0, 2.0, 0.0}, 40, 30};
  base.cells.assign(base.geometry.cell_count(), 20);
  OccupancyGrid revision = base;
  for (int row = 5; row < 8; ++row) revision.cells[revision.geometry.index(10, row)] = 240;
  for (const int step : {0, 1}) base.cells[base.geometry.index(30 + step, 20 + step)] = 240;
  ASSERT_OK_AND_ASSIGN(const MapDiff diff,
                       DiffRasters(FromOccupancyGrid(base), FromOccupancyGrid(revision), {.with_geojson = true}));
  const auto document = nlohmann::json::parse(diff.geojson);
  ASSERT_EQ(document["features"].size(), 2U);
  const auto& came = document["features"][0];
  EXPECT_EQ(came["properties"]["change"], "came");
  EXPECT_EQ(came["properties"]["cells"], 3);
  EXPECT_NEAR(came["properties"]["area_m2"].get<double>(), 0.03, 1e-9);
  EXPECT_EQ(came["geometry"]["type"], "Polygon");
  std::vector<double> x, y;
  for (const auto& position : came["geometry"]["coordinates"][0]) {
    x.push_back(position[0]);
    y.push_back(position[1]);
  }
  EXPECT_THAT(x, SizeIs(5)) << "the last position is the first again";
  EXPECT_EQ(x.front(), x.back());
  EXPECT_NEAR(*std::min_element(x.begin(), x.end()), 0.0, 1e-9);
  EXPECT_NEAR(*std::max_element(x.begin(), x.end()), 0.1, 1e-9);
  EXPECT_NEAR(*std::min_element(y.begin(), y.end()), 2.5, 1e-9);
  EXPECT_NEAR(*std::max_element(y.begin(), y.end()), 2.8, 1e-9);
  const auto& went = document["features"][1];
  EXPECT_EQ(went["properties"]["change"], "went");
  EXPECT_EQ(went["geometry"]["type"], "MultiPolygon") << "two cells that touch at a corner";
  EXPECT_EQ(went["geometry"]["coordinates"].size(), 2U);
}

}  // namespace
}  // namespace enfilade::grid
