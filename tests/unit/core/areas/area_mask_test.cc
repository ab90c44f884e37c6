// SPDX-License-Identifier: Apache-2.0
#include "core/areas/area_mask.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "core/areas/area_files.h"
#include "core/areas/rasterize_area.h"
#include "core/grid/files/map_files.h"
#include "core/grid/occupancy_values.h"
#include "tests/support/status_assertions.h"

namespace enfilade::areas {
namespace {

using Eigen::Vector2d;
using ::testing::HasSubstr;

// 8 x 5 cells of 1 m.
const grid::GridGeometry kCells{1.0, {}, 8, 5};

MapArea AreaOf(AreaKind kind, std::vector<Vector2d> outline, double speed = 0.0, std::string name = "area") {
  MapArea area;
  area.kind = kind;
  area.display_name = std::move(name);
  area.outline = std::move(outline);
  area.speed_limit_mps = speed;
  return area;
}
std::vector<Vector2d> Box(double x0, double y0, double x1, double y1) {
  return {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
}

// The cells that an area has, as text; the highest row first.
std::string Draw(const std::vector<Vector2d>& outline, const grid::GridGeometry& geometry, AreaCells cells) {
  std::vector<std::string> rows(geometry.height, std::string(geometry.width, '.'));
  RasterizeArea(outline, geometry, cells, [&](int row, int first, int last) {
    for (int column = first; column <= last; ++column) rows.at(row).at(column) = '#';
  });
  std::string text;
  for (auto row = rows.rbegin(); row != rows.rend(); ++row) text += *row + "\n";
  return text;
}

TEST(RasterizeArea, CellsAlongTheEdgeBelongByTheirCentre) {
  EXPECT_EQ(Draw(Box(1, 1, 4, 3), kCells, AreaCells::kInside), "........\n........\n.###....\n.###....\n........\n");
  EXPECT_EQ(Draw(Box(1.5, 1.5, 4.5, 3.5), kCells, AreaCells::kInside),
            "........\n.####...\n.####...\n.####...\n........\n")
      << "centres on the edge belong to it";
  EXPECT_EQ(Draw(Box(1.6, 1.6, 4.4, 3.4), kCells, AreaCells::kInside),
            "........\n........\n..##....\n........\n........\n");
}

TEST(RasterizeArea, EnteredCellsAreAllThatTheAreaHasAPartOf) {
  EXPECT_EQ(Draw(Box(1, 1, 4, 3), kCells, AreaCells::kEntered), "........\n........\n.###....\n.###....\n........\n")
      << "not those that it only borders on";
  EXPECT_EQ(Draw(Box(1.6, 1.6, 4.4, 3.4), kCells, AreaCells::kEntered),
            "........\n.####...\n.####...\n.####...\n........\n");
  EXPECT_EQ(Draw(Box(2.2, 0.1, 2.3, 4.9), kCells, AreaCells::kEntered),
            "..#.....\n..#.....\n..#.....\n..#.....\n..#.....\n")
      << "also one that is narrower than a cell";
}

TEST(RasterizeArea, ShapesWithNotchesAndBeyondTheGrid) {
  const std::vector<Vector2d> notched = {{-3, -3}, {12, -3}, {12, 9}, {5, 9}, {5, 2}, {3, 2}, {3, 9}, {-3, 9}};
  for (const AreaCells cells : {AreaCells::kInside, AreaCells::kEntered}) {
    EXPECT_EQ(Draw(notched, kCells, cells), "###..###\n###..###\n###..###\n########\n########\n");
    EXPECT_EQ(Draw(Box(20, 0, 30, 5), kCells, cells), "........\n........\n........\n........\n........\n");
    EXPECT_EQ(Draw(Box(0, -9, 8, -1), kCells, cells), "........\n........\n........\n........\n........\n");
    EXPECT_EQ(Draw(Box(-9e5, -9e5, 9e5, 9e5), kCells, cells), "########\n########\n########\n########\n########\n");
  }
}

TEST(RasterizeArea, TheGridMayBeShiftedAndTurned) {
  const grid::GridGeometry turned{0.5, {10, 20, M_PI / 2}, 8, 5};
  // 2 m x 1 m in the map, from the grid's origin: the grid's x axis is the map's y axis.
  EXPECT_EQ(Draw({{8, 20}, {10, 20}, {10, 21}, {8, 21}}, turned, AreaCells::kInside),
            "........\n##......\n##......\n##......\n##......\n");
}

// Each cell by itself: is its centre inside, and does the polygon enter it?
class RandomOutlineTest : public ::testing::TestWithParam<int> {};

bool IsInside(const std::vector<Vector2d>& outline, const Vector2d& p) {
  bool inside = false;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vector2d& a = outline[i];
    const Vector2d& b = outline[(i + 1) % outline.size()];
    if ((a.y() > p.y()) != (b.y() > p.y()) && p.x() < a.x() + (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y())) {
      inside = !inside;
    }
  }
  return inside;
}

TEST_P(RandomOutlineTest, IsAsCellByCell) {
  std::mt19937 random(static_cast<unsigned>(GetParam()));
  std::uniform_real_distribution<double> radius(0.3, 9.0);
  std::uniform_real_distribution<double> place(-2.0, 18.0);
  const grid::GridGeometry geometry{0.7, {1.0, -2.0, 0.4}, 24, 17};
  const Vector2d centre(place(random), place(random));
  std::vector<Vector2d> outline;  // a star, which is simple
  for (int i = 0; i < 23; ++i) {
    const double angle = 2.0 * M_PI * i / 23.0;
    outline.push_back(centre + radius(random) * Vector2d(std::cos(angle), std::sin(angle)));
  }
  const auto centre_inside = [&](double column, double row) {
    return IsInside(outline, geometry.T_map_grid * Vector2d(column * geometry.resolution, row * geometry.resolution));
  };
  std::vector<std::uint8_t> inside(geometry.cell_count()), entered(geometry.cell_count());
  RasterizeArea(outline, geometry, AreaCells::kInside, [&](int row, int first, int last) {
    for (int column = first; column <= last; ++column) inside.at(geometry.index(column, row)) = 1;
  });
  RasterizeArea(outline, geometry, AreaCells::kEntered, [&](int row, int first, int last) {
    for (int column = first; column <= last; ++column) entered.at(geometry.index(column, row)) = 1;
  });
  constexpr int kParts = 12;
  for (int row = 0; row < geometry.height; ++row) {
    for (int column = 0; column < geometry.width; ++column) {
      const std::size_t cell = geometry.index(column, row);
      EXPECT_EQ(inside[cell] == 1, centre_inside(column + 0.5, row + 0.5)) << column << ' ' << row;
      bool has_part = false;
      for (int i = 0; i < kParts * kParts; ++i) {
        has_part = has_part || centre_inside(column + (i % kParts + 0.5) / kParts, row + (i / kParts + 0.5) / kParts);
      }
      if (has_part || inside[cell] == 1) {
        EXPECT_EQ(entered[cell], 1) << column << ' ' << row;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomOutlineTest, ::testing::Range(1, 21));

// What Nav2's map server reads in the files, the highest row first: a digit for each tenth.
std::vector<int> ReadByNav2(const std::vector<grid::MapFile>& files, grid::GridGeometry* geometry = nullptr) {
  const auto imported = grid::ImportFiles(files, grid::MapDialect::kNav2);
  EXPECT_OK(imported);
  if (!imported.ok()) return {};
  EXPECT_TRUE(imported->warnings.empty()) << imported->warnings.front();
  const auto& cells = std::get<grid::GreyCells>(imported->raster.cells);
  EXPECT_EQ(cells.interpretation.mode, grid::MapMode::kRaw);
  std::vector<int> values;
  for (const std::uint8_t grey : cells.grey) values.push_back(grid::LoadedValue(cells.interpretation, grey));
  if (geometry != nullptr) *geometry = imported->raster.geometry;
  return values;
}

std::string YamlOf(const std::vector<grid::MapFile>& files) {
  for (const grid::MapFile& file : files) {
    if (file.name.ends_with(".yaml")) return file.bytes;
  }
  return "";
}

TEST(KeepOutMask, IsLethalInKeepOutAreasAndFreeElsewhere) {
  const grid::GridGeometry cells{0.05, {-1.5, 2.25, 0.1}, 4, 2};
  const auto whole = AreaOf(AreaKind::kKeepOut, {{-1.5, 2.2}, {-1.4, 2.2}, {-1.4, 2.5}, {-1.5, 2.5}});
  ASSERT_OK_AND_ASSIGN(const auto files, RenderKeepOutMask({whole, AreaOf(AreaKind::kRoom, Box(-9, -9, 9, 9))}, cells));
  ASSERT_EQ(files.size(), 2U);
  EXPECT_EQ(files[0].name, "keepout.pgm");
  EXPECT_EQ(files[1].name, "keepout.yaml");
  grid::GridGeometry read;
  const std::vector<int> values = ReadByNav2(files, &read);
  EXPECT_EQ(read, cells) << "the cells of the map, to the last digit";
  EXPECT_EQ(values, (std::vector<int>{100, 100, 100, 0, 100, 100, 100, 0}));
  for (const char* line : {"#   type: 0\n", "#   base: 0.0\n", "#   multiplier: 1.0\n", "mode: raw\n"}) {
    EXPECT_THAT(YamlOf(files), HasSubstr(line));
  }
}

TEST(KeepOutMask, PreferredAreasAreCheaperThanTheRestAndKeepOutLiesAbove) {
  const std::vector<MapArea> areas = {AreaOf(AreaKind::kKeepOut, Box(0, 0, 2, 1)),
                                      AreaOf(AreaKind::kPreferred, Box(1, 0, 6, 2))};
  ASSERT_OK_AND_ASSIGN(const auto files, RenderKeepOutMask(areas, kCells));
  const std::vector<int> values = ReadByNav2(files);
  EXPECT_EQ(std::vector<int>(values.begin(), values.begin() + 8), (std::vector<int>{100, 100, 0, 0, 0, 0, 25, 25}));
  EXPECT_EQ(std::vector<int>(values.begin() + 8, values.begin() + 16), (std::vector<int>{25, 0, 0, 0, 0, 0, 25, 25}));
}

TEST(SpeedMask, SaysEachLimitExactlyAsMultiples) {
  const std::vector<MapArea> areas = {AreaOf(AreaKind::kSpeedLimit, Box(0, 0, 2, 1), 1.2),
                                      AreaOf(AreaKind::kSpeedLimit, Box(1, 0, 4, 1), 0.3),
                                      AreaOf(AreaKind::kSpeedLimit, Box(3, 0, 6, 1), 0.5)};
  ASSERT_OK_AND_ASSIGN(const SpeedMask mask, MakeSpeedMask(areas, kCells));
  EXPECT_NEAR(mask.multiplier, 0.1, 1e-12);
  EXPECT_TRUE(mask.rounded.empty());
  ASSERT_OK_AND_ASSIGN(const auto files, RenderSpeedMask(areas, kCells));
  EXPECT_EQ(files[0].name, "speed.pgm");
  const std::vector<int> values = ReadByNav2(files);
  EXPECT_EQ(std::vector<int>(values.begin(), values.begin() + 8), (std::vector<int>{12, 3, 3, 3, 5, 5, 0, 0}))
      << "the lowest limit holds, and 0 is none";
  for (const char* line : {"#   type: 2\n", "#   base: 0.0\n", "#   multiplier: 0.1\n"}) {
    EXPECT_THAT(YamlOf(files), HasSubstr(line));
  }
}

TEST(SpeedMask, RoundsDownWhatNoMultipleSays) {
  const std::vector<MapArea> areas = {AreaOf(AreaKind::kSpeedLimit, Box(0, 0, 1, 1), 1.0),
                                      AreaOf(AreaKind::kSpeedLimit, Box(1, 0, 2, 1), 0.3337, "Ramp\nup")};
  ASSERT_OK_AND_ASSIGN(const SpeedMask mask, MakeSpeedMask(areas, kCells));
  EXPECT_NEAR(mask.multiplier, 0.01, 1e-12);
  ASSERT_EQ(mask.rounded.size(), 1U);
  EXPECT_NEAR(mask.rounded[0].said_mps, 0.33, 1e-12);
  ASSERT_OK_AND_ASSIGN(const auto files, RenderSpeedMask(areas, kCells));
  EXPECT_THAT(YamlOf(files), HasSubstr("# \"Ramp up\": 0.3337 m/s is said as 0.33 m/s.\n"));
  const std::vector<int> values = ReadByNav2(files);
  EXPECT_EQ(values[0], 100);
  EXPECT_EQ(values[1], 33);
}

TEST(SpeedMask, RefusesALimitThatWouldReadAsNone) {
  EXPECT_STATUS(MakeSpeedMask({AreaOf(AreaKind::kSpeedLimit, Box(0, 0, 1, 1), 2.0),
                               AreaOf(AreaKind::kSpeedLimit, Box(1, 0, 2, 1), 0.0123, "Crawl")},
                              kCells),
                absl::StatusCode::kFailedPrecondition, HasSubstr("area \"Crawl\" has the limit 0.0123 m/s"));
}

TEST(SpeedMask, HasAWholeMultiplierAsAFloatingPointNumber) {
  ASSERT_OK_AND_ASSIGN(const auto files,
                       RenderSpeedMask({AreaOf(AreaKind::kSpeedLimit, Box(0, 0, 1, 1), 1.0)}, kCells));
  EXPECT_THAT(YamlOf(files), HasSubstr("multiplier: 1.0\n"));
  ASSERT_OK_AND_ASSIGN(const auto none, RenderSpeedMask({}, kCells));
  EXPECT_EQ(ReadByNav2(none), std::vector<int>(40, 0));
}

}  // namespace
}  // namespace enfilade::areas
