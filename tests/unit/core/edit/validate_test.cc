// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "core/edit/map_edit.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/edit/covered_cells.h"
#include "tests/unit/core/edit/random_edits.h"

namespace enfilade::edit {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;

// From side to side, a step up each time.
std::vector<LatticePoint> Zigzag(int points, int step_x, int step_y) {
  std::vector<LatticePoint> path;
  for (int i = 0; i < points; ++i) path.push_back({i % 2 == 0 ? 128 : 128 + step_x, 128 + i * step_y});
  return path;
}

std::int64_t CountOf(const Shape& shape) {
  Overlay overlay;
  overlay.Draw({Instruction::kFree, shape, false});
  std::int64_t cells = 0;
  for (const auto& [index, tile] : overlay.tiles()) {
    cells += std::count(tile.begin(), tile.end(), static_cast<std::uint8_t>(Instruction::kFree));
  }
  return cells;
}

std::vector<LatticePoint> Square(int side) { return {{0, 0}, {side, 0}, {side, side}, {0, side}}; }

TEST(ValidateEdit, AcceptsWhatIsWithinTheLimits) {
  EXPECT_OK(Validate(Brush{{{kMaxCoordinate, -kMaxCoordinate}}, kMaxRadius}));
  EXPECT_OK(Validate(Line{{{0, 0}, {kMaxSide, -kMaxSide}}}));
  EXPECT_OK(Validate(Line{Zigzag(static_cast<int>(kMaxPoints), 2'560, 0)}));
  EXPECT_OK(Validate(Polygon{{Square(2000 * kUnitsPerCell)}}));  // 4,000,000 cells
  EXPECT_OK(Validate(Patch{{0, 0, 2000, 2000}, {0, 4'000'000}}));
  EXPECT_OK(Validate(Patch{{-2'097'152, -2'097'152, 4'194'304, 4'194'304}, {0, 1, 0xFFFFFFFF, 1}}));
}

TEST(ValidateEdit, RefusesNoPointsAndTooMany) {
  EXPECT_STATUS(Validate(Brush{{}, 5}), kInvalid, HasSubstr("no points"));
  EXPECT_STATUS(Validate(Line{}), kInvalid, HasSubstr("no points"));
  EXPECT_STATUS(Validate(Polygon{}), kInvalid, HasSubstr("no rings"));
  EXPECT_STATUS(Validate(Polygon{{{{0, 0}, {5, 5}}}}), kInvalid, HasSubstr("2 points: expected at least 3"));
  EXPECT_STATUS(Validate(Line{std::vector<LatticePoint>(10'001)}), kInvalid,
                AllOf(HasSubstr("10001 points"), HasSubstr("10000"), HasSubstr("split")));
  EXPECT_STATUS(Validate(Polygon{{Square(999), std::vector<LatticePoint>(10'000)}}), kInvalid,
                HasSubstr("more than 10000 points"));
}

TEST(ValidateEdit, RefusesARadiusThatIsOutOfRange) {
  EXPECT_STATUS(Validate(Brush{{{0, 0}}, -1}), kInvalid, AllOf(HasSubstr("radius is -1"), HasSubstr("0 to 65536")));
  EXPECT_STATUS(Validate(Brush{{{0, 0}}, kMaxRadius + 1}), kInvalid, HasSubstr("radius is 65537"));
}

TEST(ValidateEdit, RefusesCoordinatesAndSidesThatAreTooLarge) {
  const int far = kMaxCoordinate + 1;
  EXPECT_STATUS(Validate(Brush{{{0, 0}, {1, far}}, 300}), kInvalid,
                AllOf(HasSubstr("point 2 is (1, 536870913)"), HasSubstr("536870912")));
  EXPECT_STATUS(Validate(Line{{{std::numeric_limits<int>::min(), 0}}}), kInvalid, HasSubstr("-2147483648"));
  EXPECT_STATUS(Validate(Polygon{{{{0, 0}, {0, -far}, {5, 5}}}}), kInvalid, HasSubstr("point 2"));
  EXPECT_STATUS(Validate(Line{{{0, 0}, {kMaxSide + 1, 0}}}), kInvalid,
                AllOf(HasSubstr("segment to point 2"), HasSubstr("16384 cells")));
  EXPECT_STATUS(Validate(Polygon{{{{0, 0}, {5, kMaxSide}, {-5, kMaxSide + 1}}}}), kInvalid,
                HasSubstr("segment to point 1"));  // the side that closes the ring
}

TEST(ValidateEdit, RefusesRingsThatCrossThemselves) {
  EXPECT_STATUS(Validate(Polygon{{{{0, 0}, {1000, 1000}, {1000, 0}, {0, 1000}}}}), kInvalid,
                AllOf(HasSubstr("sides 1 and 3"), HasSubstr("several polygons")));
  // Rings may touch themselves, and others in any way.
  EXPECT_OK(Validate(Polygon{{{{0, 0}, {1000, 0}, {500, 500}, {1000, 1000}, {0, 1000}, {500, 500}}}}));
  EXPECT_OK(Validate(Polygon{{Square(1000), {{500, 500}, {2000, 500}, {2000, 2000}}}}));
}

// Crossings against all pairs of sides.
TEST(ValidateEdit, FindsEveryCrossing) {
  const auto turn = [](LatticePoint a, LatticePoint b, LatticePoint c) {
    const std::int64_t value = std::int64_t{b.x - a.x} * (c.y - a.y) - std::int64_t{b.y - a.y} * (c.x - a.x);
    return value > 0 ? 1 : (value < 0 ? -1 : 0);
  };
  std::mt19937 random(4);
  int crossing = 0;
  for (int i = 0; i < 3000; ++i) {
    std::vector<LatticePoint> ring;
    for (std::uint32_t corners = 3 + random() % 4; corners > 0; --corners) {
      ring.push_back({static_cast<int>(random() % 8) * 300, static_cast<int>(random() % 8) * 300});
    }
    bool crosses = false;
    for (std::size_t j = 0; j < ring.size(); ++j) {
      for (std::size_t k = 0; k < j; ++k) {
        const LatticePoint a = ring[j], b = ring[(j + 1) % ring.size()], c = ring[k], d = ring[(k + 1) % ring.size()];
        crosses = crosses || (turn(a, b, c) * turn(a, b, d) < 0 && turn(c, d, a) * turn(c, d, b) < 0);
      }
    }
    crossing += crosses ? 1 : 0;
    ASSERT_EQ(ValidateForm(Polygon{{ring}}).ok(), !crosses) << i;
  }
  EXPECT_GT(crossing, 500);
  EXPECT_LT(crossing, 2500);
}

TEST(ValidateEdit, RefusesPatchesThatDoNotFitTheirBox) {
  EXPECT_STATUS(Validate(Patch{{0, 0, 0, 5}, {0, 1}}), kInvalid, HasSubstr("0 x 5 cells"));
  EXPECT_STATUS(Validate(Patch{{0, 0, 5, -1}, {0, 1}}), kInvalid, HasSubstr("5 x -1 cells"));
  EXPECT_STATUS(Validate(Patch{{2'097'153, 0, 1, 1}, {0, 1}}), kInvalid, HasSubstr("(2097153, 0)"));
  EXPECT_STATUS(Validate(Patch{{0, 0, 3, 3}, {5, 5}}), kInvalid, AllOf(HasSubstr("10 cells"), HasSubstr("3 x 3")));
  EXPECT_STATUS(Validate(Patch{{0, 0, 3, 3}, {0xFFFFFFFF, 0xFFFFFFFF}}), kInvalid, HasSubstr("8589934590 cells"));
}

TEST(ValidateEdit, RefusesShapesWithoutACell) {
  EXPECT_STATUS(Validate(Brush{{{0, 0}}, 181}), kInvalid, HasSubstr("covers no cell"));  // a corner of cells
  EXPECT_OK(Validate(Brush{{{0, 0}}, 182}));
  EXPECT_STATUS(Validate(Patch{{0, 0, 3, 3}, {}}), kInvalid, HasSubstr("covers no cell"));
  EXPECT_STATUS(Validate(Patch{{0, 0, 3, 3}, {9}}), kInvalid, HasSubstr("covers no cell"));
  EXPECT_STATUS(Validate(Polygon{{{{0, 0}, {100, 0}, {0, 100}}}}), kInvalid, HasSubstr("covers no cell"));
}

TEST(ValidateEdit, RefusesMoreCellsThanOneEditMayHave) {
  EXPECT_STATUS(Validate(Polygon{{Square(2001 * kUnitsPerCell)}}), kInvalid,
                AllOf(HasSubstr("4004001 cells"), HasSubstr("4000000"), HasSubstr("split")));
  EXPECT_STATUS(Validate(Patch{{0, 0, 2001, 2000}, {0, 4'002'000}}), kInvalid, HasSubstr("4002000 cells"));
  EXPECT_STATUS(Validate(Line{Zigzag(1'000, kMaxSide, 1)}), kInvalid, HasSubstr("cells"));
  EXPECT_STATUS(Validate(Brush{Zigzag(9'000, 0, 1024), kMaxRadius}), kInvalid, HasSubstr("rows"));
}

// A brush may pass over the same cells again and again.
TEST(ValidateEdit, CountsEachCellOnce) {
  EXPECT_OK(Validate(Brush{Zigzag(2'000, 25'600, 0), 25'600}));
  const Brush within{Zigzag(30, 300'000, 12'800), 25'600};
  EXPECT_LE(CountOf(within), 4'000'000);
  EXPECT_OK(Validate(within));
  const Brush beyond{Zigzag(70, 300'000, 12'800), 25'600};
  EXPECT_STATUS(Validate(beyond), kInvalid, HasSubstr(std::to_string(CountOf(beyond)) + " cells"));
}

TEST(ValidateEdit, AcceptsWhatTheOtherTestsDraw) {
  std::mt19937 random(9);
  for (int i = 0; i < 2000; ++i) ASSERT_OK(Validate(RandomShapes{{-9'000, 70'000}}.RandomShape(random))) << i;
}

TEST(ValidateEdit, RefusesThinShapesThatTouchTooManyTiles) {
  constexpr int kTile = 256 * kUnitsPerCell;
  EXPECT_OK(Validate(Line{Zigzag(32, 31 * kTile, kTile)}));  // 32 x 32 tiles
  EXPECT_STATUS(Validate(Line{Zigzag(34, 31 * kTile, kTile)}), kInvalid,
                AllOf(HasSubstr("more than 1024 tiles of 256 x 256 cells"), HasSubstr("split")));
}

}  // namespace
}  // namespace enfilade::edit
