// SPDX-License-Identifier: Apache-2.0
#include "core/edit/spans.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/status_assertions.h"
#include "tests/unit/core/edit/covered_cells.h"
#include "tests/unit/core/edit/random_edits.h"

namespace enfilade::edit {
namespace {

using Picture = std::vector<std::string>;

// Where shapes lie: at the origin, across edges of tiles on all sides of it, and at the limits of coordinates.
const std::vector<RandomShapes>& Places() {
  constexpr int kTile = 256 * kUnitsPerCell;
  constexpr int kFar = kMaxCoordinate - 30'000;
  static const std::vector<RandomShapes> places = {{{0, 0}, 3'000},
                                                   {{-kTile, kTile}, 3'000},
                                                   {{5 * kTile, -3 * kTile}, 3'000},
                                                   {{-40'000, -40'000}, 9'000, 900},
                                                   {{kFar, -kFar}, 9'000},
                                                   {{-kFar, kFar}, 9'000}};
  return places;
}

template <typename MakeShape>
void ExpectExactCells(int shapes_per_place, MakeShape make_shape) {
  std::mt19937 random(22);
  for (const RandomShapes& place : Places()) {
    for (int i = 0; i < shapes_per_place; ++i) {
      const Shape shape = make_shape(place, random);
      ASSERT_OK(ValidateForm(shape));
      ASSERT_TRUE(DrawnCells(shape) == CoveredCells(shape))
          << "shape " << i << " at " << place.at.x << ", " << place.at.y << " of " << Encode(shape).size() << " bytes";
    }
  }
}

TEST(Spans, BrushesCoverExactlyTheCentresWithinTheirRadius) {
  ExpectExactCells(400, [](const RandomShapes& place, std::mt19937& random) { return place.RandomBrush(random); });
}

TEST(Spans, LinesCoverTheCellsNearestToThem) {
  ExpectExactCells(1000, [](const RandomShapes& place, std::mt19937& random) { return place.RandomLine(random); });
}

TEST(Spans, PolygonsCoverExactlyTheCentresInsideAndOnTheirSides) {
  ExpectExactCells(400, [](const RandomShapes& place, std::mt19937& random) { return place.RandomPolygon(random); });
}

TEST(Spans, PatchesCoverTheCellsThatTheirRunsTake) {
  ExpectExactCells(400, [](const RandomShapes& place, std::mt19937& random) { return place.RandomPatch(random); });
}

TEST(Spans, ThinBrushesAreExactInEveryDirection) {
  std::mt19937 random(5);
  for (int i = 0; i < 1500; ++i) {
    const LatticePoint a{static_cast<int>(random() % 9000) - 4500, static_cast<int>(random() % 9000) - 4500};
    const LatticePoint b{static_cast<int>(random() % 9000) - 4500, static_cast<int>(random() % 9000) - 4500};
    const Brush brush{{a, b}, static_cast<std::int32_t>(random() % 4 == 0 ? 0 : random() % 130)};
    ASSERT_TRUE(DrawnCells(brush) == CoveredCells(brush))
        << a.x << ", " << a.y << " to " << b.x << ", " << b.y << " with " << brush.radius;
  }
}

TEST(Spans, PolygonsOfACornerOnEachCentreAreExact) {
  std::mt19937 random(6);
  for (int i = 0; i < 3000; ++i) {  // small ones, whose corners, sides and centres often coincide
    std::vector<LatticePoint> ring;
    for (int corner = 0; corner < 3; ++corner) {
      ring.push_back(Centre(static_cast<int>(random() % 9) - 4, static_cast<int>(random() % 9) - 4));
    }
    const Polygon polygon{{ring}};
    ASSERT_TRUE(DrawnCells(polygon) == CoveredCells(polygon)) << i;
  }
}

// A brush is as far from its reverse as from itself.
TEST(Spans, DirectionDoesNotMatter) {
  std::mt19937 random(7);
  for (int i = 0; i < 500; ++i) {
    const RandomShapes& place = Places()[random() % Places().size()];
    Brush brush = place.RandomBrush(random);
    Line line = place.RandomLine(random);
    const CellSet brushed = DrawnCells(brush);
    const CellSet lined = DrawnCells(line);
    std::reverse(brush.points.begin(), brush.points.end());
    std::reverse(line.points.begin(), line.points.end());
    EXPECT_TRUE(DrawnCells(brush) == brushed);
    EXPECT_TRUE(DrawnCells(line) == lined);
  }
}

TEST(Spans, AreInsideTheBox) {
  std::mt19937 random(8);
  for (int i = 0; i < 1000; ++i) {
    const Shape shape = Places()[random() % Places().size()].RandomShape(random);
    const CellBox box = BoxOf(shape);
    for (const auto& [column, row] : DrawnCells(shape)) ASSERT_TRUE(box.contains(column, row)) << i;
  }
}

TEST(Spans, ABrushWithoutRadiusCoversCentresAlone) {
  EXPECT_EQ(PictureOf(Brush{Centres({{1, 1}}), 0}, {0, 0, 3, 3}), (Picture{"...", ".#.", "..."}));
  EXPECT_EQ(DrawnCells(Brush{{{129, 128}}, 0}), CellSet{});
  EXPECT_EQ(PictureOf(Brush{Centres({{0, 0}, {4, 2}}), 0}, {0, 0, 5, 3}), (Picture{"....#", "..#..", "#...."}));
}

TEST(Spans, ABrushCoversCentresOnItsEdge) {
  EXPECT_EQ(PictureOf(Brush{Centres({{2, 2}}), 2 * kUnitsPerCell}, {0, 0, 5, 5}),
            (Picture{"..#..", ".###.", "#####", ".###.", "..#.."}));
  EXPECT_EQ(PictureOf(Brush{Centres({{2, 2}}), 2 * kUnitsPerCell - 1}, {0, 0, 5, 5}),
            (Picture{".....", ".###.", ".###.", ".###.", "....."}));
  EXPECT_EQ(PictureOf(Brush{Centres({{1, 1}, {4, 1}}), kUnitsPerCell}, {0, 0, 6, 3}),
            (Picture{".####.", "######", ".####."}));
}

TEST(Spans, LinesTakeTheGreaterOfTwoCellsThatAreEquallyNear) {
  EXPECT_EQ(PictureOf(Line{Centres({{0, 0}, {4, 2}})}, {0, 0, 5, 3}), (Picture{"...##", ".##..", "#...."}));
  EXPECT_EQ(PictureOf(Line{Centres({{4, 2}, {0, 0}})}, {0, 0, 5, 3}), (Picture{"...##", ".##..", "#...."}));
  EXPECT_EQ(PictureOf(Line{Centres({{0, 0}, {0, 2}, {2, 2}})}, {0, 0, 3, 3}), (Picture{"###", "#..", "#.."}));
}

TEST(Spans, PolygonsHaveHolesAndIslands) {
  const Polygon polygon{{Centres({{0, 0}, {8, 0}, {8, 8}, {0, 8}}),
                         {{384, 384}, {384, 1920}, {1920, 1920}, {1920, 384}},  // edges within the hole's own cells
                         {{3 * 256, 3 * 256}, {6 * 256, 3 * 256}, {6 * 256, 6 * 256}, {3 * 256, 6 * 256}}}};
  EXPECT_EQ(PictureOf(polygon, {0, 0, 9, 9}), (Picture{"#########", "#########", "##.....##", "##.###.##", "##.###.##",
                                                       "##.###.##", "##.....##", "#########", "#########"}));
}

TEST(Spans, PolygonsCoverCentresOnSidesAndCorners) {
  const Polygon triangle{{Centres({{0, 0}, {4, 0}, {0, 4}})}};
  EXPECT_EQ(PictureOf(triangle, {0, 0, 5, 5}), (Picture{"#....", "##...", "###..", "####.", "#####"}));
  const Polygon flat{{Centres({{0, 1}, {4, 1}, {2, 1}})}};
  EXPECT_EQ(PictureOf(flat, {0, 0, 5, 3}), (Picture{".....", "#####", "....."}));
  const Polygon cells{{{{256, 256}, {768, 256}, {768, 768}, {256, 768}}}};  // along edges of cells
  EXPECT_EQ(PictureOf(cells, {0, 0, 4, 4}), (Picture{"....", ".##.", ".##.", "...."}));
}

TEST(Spans, RunsOfPatchesGoOnInTheNextRow) {
  EXPECT_EQ(PictureOf(Patch{{1, 0, 3, 3}, {1, 4, 2, 1}}, {0, 0, 5, 3}), (Picture{"..#..", ".##..", "..##."}));
}

}  // namespace
}  // namespace enfilade::edit
