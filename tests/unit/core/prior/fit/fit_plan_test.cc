// SPDX-License-Identifier: Apache-2.0
#include "core/prior/fit/fit_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "tests/support/plans/drawn_building.h"
#include "tests/support/plans/random_building.h"

namespace enfilade::prior {
namespace {

PlanTransform Turned(double turn) {
  Eigen::Matrix2d rotation;
  rotation << std::cos(turn), -std::sin(turn), std::sin(turn), std::cos(turn);
  return {0.05 * rotation * Eigen::Vector2d(1, -1).asDiagonal(), {3.5, -7.25}};
}

bool IsWest(const Eigen::Vector2d& sheet) { return sheet.x() < 520; }
bool IsEast(const Eigen::Vector2d& sheet) { return sheet.x() > 330; }
bool IsMost(const Eigen::Vector2d& sheet) { return sheet.x() < 800; }
bool IsRoom(const Eigen::Vector2d& sheet) { return sheet.x() < 102 && sheet.y() < 202; }

constexpr Pose2 kPlaceOfSecond{12.0, -4.0, 2.2};  // T_first_second

grid::OccupancyGrid Seen(const PlanGraph& plan, const Pose2& T_map_first,
                         const std::function<bool(const Eigen::Vector2d&)>& is_seen) {
  const PlanTransform truth = T_map_first * Turned(0.3);
  return MapOf(plan, truth, is_seen);
}

TEST(FitPlan, JoinsTwoMapsByThePlan) {
  const PlanGraph plan = DrawnBuilding();
  const auto fit = FitPlan(plan, {Seen(plan, {}, IsWest), Seen(plan, Inverse(kPlaceOfSecond), IsEast)}, {});
  ASSERT_TRUE(fit.ok()) << fit.status();
  ASSERT_TRUE(fit->alignment.accepted) << fit->alignment.reason;
  ASSERT_TRUE(fit->maps[1].T_first_map.has_value()) << fit->maps[1].alignment.reason;
  const Pose2 error = Between(kPlaceOfSecond, *fit->maps[1].T_first_map);
  EXPECT_LT(error.translation().norm(), 0.06);
  EXPECT_LT(std::abs(error.yaw), 0.005);
  // Both have been seen: the east end by the second robot only.
  const CorrectedPoint east = fit->corrected->Locate({880, 160});
  EXPECT_EQ(east.sight, Sight::kSeen);
  EXPECT_LT((east.point - Turned(0.3)(Eigen::Vector2d(880, 160))).norm(), 0.1);
}

// One room fits in many places; by the scale that another map tells it still does.
TEST(FitPlan, LeavesOutAMapThatFitsInManyPlaces) {
  const PlanGraph plan = DrawnBuilding();
  const auto fit = FitPlan(plan, {Seen(plan, {}, IsWest), Seen(plan, {1, 2, 0.5}, IsRoom)}, {});
  ASSERT_TRUE(fit.ok()) << fit.status();
  EXPECT_TRUE(fit->alignment.accepted);
  EXPECT_FALSE(fit->maps[1].T_first_map.has_value());
  EXPECT_FALSE(fit->maps[1].alignment.accepted);
}

// It has walls where the first map has seen free ground.
TEST(FitPlan, LeavesOutAMapThatContradictsTheOthers) {
  const PlanGraph plan = DrawnBuilding();
  PlanGraph walled = plan;
  for (const double y : {100.0, 225.0, 360.0}) DrawWall(walled, {30, y}, {490, y});
  const auto fit = FitPlan(plan, {Seen(plan, {}, IsWest), Seen(walled, Inverse(kPlaceOfSecond), IsMost)}, {});
  ASSERT_TRUE(fit.ok()) << fit.status();
  EXPECT_TRUE(fit->alignment.accepted);
  EXPECT_FALSE(fit->maps[1].T_first_map.has_value());
  EXPECT_FALSE(fit->maps[1].alignment.accepted);
  EXPECT_THAT(fit->maps[1].alignment.reason, testing::HasSubstr("other maps know lie in free ground"));
}

// 34 m x 24 m, with the same rooms on both sides of a corridor, but for a wall that is `aside` (m).
PlanGraph TwoSidedBuilding(double aside) {
  PlanGraph plan;
  const auto wall = [&](double x0, double y0, double x1, double y1) {
    DrawWall(plan, 20 * Eigen::Vector2d(x0, y0), 20 * Eigen::Vector2d(x1, y1));
  };
  for (const double y : {0.0, 10.75, 13.25, 24.0}) wall(0, y, 34, y);
  for (const double x : {0.0, 34.0}) wall(x, 0, x, 24);
  for (const double x : {5.0, 12.0, 27.0}) wall(x, 0, x, 10.75), wall(x, 13.25, x, 24);
  wall(20, 5.5, 20, 10.75), wall(20 + aside, 13.25, 20 + aside, 18.5);
  return plan;
}

TEST(FitPlan, RefusesAPlanThatFitsAsWellTurnedOver) {
  const PlanGraph plan = TwoSidedBuilding(0);
  const auto fit = FitPlan(plan, {Seen(plan, {}, [](const auto&) { return true; })}, {});
  ASSERT_TRUE(fit.ok()) << fit.status();
  EXPECT_FALSE(fit->alignment.accepted) << fit->alignment.reason;
  EXPECT_LT(fit->alignment.rival_ratio, 1.02);
}

TEST(FitPlan, EvidenceAgainstThePlaceThatFitsBestDecidesNothing) {
  const PlanGraph plan = TwoSidedBuilding(1.5);
  PlanTransform truth = Turned(0.3);
  truth.linear.col(1) *= -1;
  const MapEvidence evidence = EvidenceOf(MapOf(plan, truth, [](const auto&) { return true; }));
  AlignOptions options;
  options.log_evidence = [](const auto&, const auto&, const PlanTransform& place) {
    return place.mirrored() ? 100.0 : 0.0;
  };
  EXPECT_TRUE(AlignByItself(plan, evidence, options).accepted);
  options.log_evidence = [](const auto&, const auto&, const PlanTransform& place) {
    return place.mirrored() ? 0.0 : 100.0;
  };
  EXPECT_FALSE(AlignByItself(plan, evidence, options).accepted);
}

TEST(FitPlan, TellsAPlanFromItsMirrorImageByOneWall) {
  const PlanGraph plan = TwoSidedBuilding(1.5);
  PlanTransform truth = Turned(0.3);
  truth.linear.col(1) *= -1;
  const auto fit = FitPlan(plan, {MapOf(plan, truth, [](const auto&) { return true; })}, {});
  ASSERT_TRUE(fit.ok()) << fit.status();
  EXPECT_TRUE(fit->alignment.accepted) << fit->alignment.reason;
  EXPECT_LT(fit->alignment.rival_ratio, AlignOptions{}.sure_rival_ratio);  // which by itself is too little
  EXPECT_TRUE(fit->alignment.T_map_sheet.mirrored());
  const Eigen::Vector2d far_corner(680, 480);
  EXPECT_LT((fit->alignment.T_map_sheet(far_corner) - truth(far_corner)).norm(), 0.3);
}

// The twins are corrected and compared, too.
TEST(FitPlan, TheResultDoesNotDependOnTheNumberOfThreads) {
  const PlanGraph plan = TwoSidedBuilding(1.5);
  const std::vector<grid::OccupancyGrid> maps = {MapOf(plan, Turned(0.3), [](const auto&) { return true; })};
  const auto one = FitPlan(plan, maps, {.threads = 1});
  const auto four = FitPlan(plan, maps, {.threads = 4});
  ASSERT_TRUE(one.ok() && four.ok());
  ASSERT_TRUE(one->corrected && four->corrected);
  EXPECT_EQ(one->alignment.reason, four->alignment.reason);
  EXPECT_EQ(one->alignment.T_map_sheet.linear, four->alignment.T_map_sheet.linear);
  EXPECT_EQ(one->alignment.T_map_sheet.offset, four->alignment.T_map_sheet.offset);
  EXPECT_EQ(one->corrected->log_evidence(), four->corrected->log_evidence());
}

TEST(FitPlan, RefusesAPlanThatIsRefusedInTheFirstMap) {
  const PlanGraph plan = DrawnBuilding();
  const auto fit = FitPlan(plan, {Seen(plan, {}, IsRoom), Seen(plan, {}, IsWest)}, {});
  ASSERT_TRUE(fit.ok()) << fit.status();
  EXPECT_FALSE(fit->alignment.accepted);
  EXPECT_EQ(fit->corrected, nullptr);
}

// It has the same outer walls and three more, and one of its own.
TEST(FitPlan, RefusesAPlanOfAnotherFloor) {
  const PlanGraph here = DrawnBuilding();
  PlanGraph other;
  for (std::size_t i = 0; i < 6; ++i) {  // the outer ones
    DrawWall(other, here.corners[2 * i].point, here.corners[2 * i + 1].point);
  }
  for (const double x : {100.0, 240.0, 320.0}) DrawWall(other, {x, 0}, {x, 200});
  DrawWall(other, {0, 340}, {680, 340});
  const auto fit = FitPlan(other, {Seen(here, {}, [](const auto&) { return true; })}, {});
  ASSERT_TRUE(fit.ok()) << fit.status();
  EXPECT_FALSE(fit->alignment.accepted);
  EXPECT_THAT(fit->alignment.reason, testing::HasSubstr("lie in free ground, at most 12 % may where it explains"));
}

TEST(FitPlan, ModesDifferInWhatFollowsTheSeenWalls) {
  const PlanGraph plan = DrawnBuilding();
  // Drawn 6 % too long along x.
  const PlanTransform drawn = Turned(0.3);
  const Placement built = [&](const Eigen::Vector2d& p) { return drawn(Eigen::Vector2d(0.94 * p.x(), p.y())); };
  const std::vector<grid::OccupancyGrid> maps = {MapOf(plan, built, IsWest)};
  std::vector<ControlPair> pairs;
  for (const Eigen::Vector2d& point : {Eigen::Vector2d(0, 0), {500, 20}, {30, 400}})
    pairs.push_back({point, built(point)});
  const Eigen::Vector2d far(880, 0);
  std::map<FitMode, double> errors;
  for (const FitMode mode : {FitMode::kFull, FitMode::kAcg, FitMode::kSimilarity, FitMode::kAffine}) {
    const auto fit = FitPlan(plan, maps, {.mode = mode, .pairs = pairs});
    ASSERT_TRUE(fit.ok()) << fit.status();
    ASSERT_TRUE(fit->alignment.accepted) << NameOf(mode) << ": " << fit->alignment.reason;
    errors[mode] = (fit->corrected->Locate(far).point - built(far)).norm();
  }
  EXPECT_LT(errors[FitMode::kAffine], 0.25 * errors[FitMode::kSimilarity]);
  EXPECT_LT(errors[FitMode::kFull], 0.25 * errors[FitMode::kSimilarity]);
  EXPECT_GT(errors[FitMode::kAcg], errors[FitMode::kFull]);
}

struct Shown {
  const char* name;
  PlanGraph plan;
  double scale = 1;  // of what is shown
  bool accepted = false;
};

std::vector<ControlPair> PairsOf(double scale) {
  std::vector<ControlPair> pairs;
  for (const Eigen::Vector2d& point : {Eigen::Vector2d(0, 0), {500, 20}, {30, 260}}) {
    pairs.push_back({point, Turned(0.3)(scale * point)});
  }
  return pairs;
}

// Neither of another building, nor ten times too large or too small; of another floor, whose outer walls are the same,
// seldom.
TEST(FitPlan, RefusesPairsOnAPlanThatIsNotOfTheMap) {
  int floors = 0;
  for (unsigned seed = 60; seed < 64; ++seed) {
    const BuildingShell shell = RandomShell(seed);
    const PlanGraph right = RandomBuilding(seed, shell);
    const std::vector<grid::OccupancyGrid> maps = {Seen(right, {}, IsWest)};
    for (const Shown& shown : {Shown{"right", right, 1, true},
                               {"building", RandomBuilding(seed + 200, RandomShell(seed + 200))},
                               {"larger", right, 10},
                               {"smaller", right, 0.1}}) {
      const auto fit = FitPlan(shown.plan, maps, {.pairs = PairsOf(shown.scale)});
      ASSERT_TRUE(fit.ok()) << fit.status();
      EXPECT_EQ(fit->alignment.accepted, shown.accepted) << shown.name << " " << seed << ": " << fit->alignment.reason;
      EXPECT_EQ(fit->corrected != nullptr, shown.accepted);
      EXPECT_EQ(fit->maps[0].T_first_map.has_value(), shown.accepted);
      if (!shown.accepted) {
        EXPECT_THAT(fit->alignment.reason, testing::HasSubstr("at that place"));
      }
    }
    const auto floor = FitPlan(RandomBuilding(seed + 100, shell), maps, {.pairs = PairsOf(1)});
    ASSERT_TRUE(floor.ok()) << floor.status();
    floors += floor->alignment.accepted ? 1 : 0;
  }
  EXPECT_LE(floors, 1);
}

// The map is that of the whole building, and the plan one of a wing.
TEST(FitPlan, WhatThePlanDoesNotShowIsNoObjection) {
  const PlanGraph building = DrawnBuilding();
  PlanGraph wing = building;
  std::erase_if(wing.walls, [&](const PlanWall& wall) {
    return building.corners[static_cast<std::size_t>(wall.from)].point.x() > 320 ||
           building.corners[static_cast<std::size_t>(wall.to)].point.x() > 320;
  });
  const auto fit = FitPlan(wing, {Seen(building, {}, [](const auto&) { return true; })}, {.pairs = PairsOf(1)});
  ASSERT_TRUE(fit.ok()) << fit.status();
  EXPECT_TRUE(fit->alignment.accepted) << fit->alignment.reason;
}

TEST(FitPlan, NamesAMapWithoutWalls) {
  const PlanGraph plan = DrawnBuilding();
  grid::OccupancyGrid blank = Seen(plan, {}, IsWest);
  std::fill(blank.cells.begin(), blank.cells.end(), grid::kUnknownCell);
  EXPECT_THAT(FitPlan(plan, {Seen(plan, {}, IsWest), blank}, {}).status().message(),
              testing::HasSubstr("map 2 has no walls"));
  EXPECT_FALSE(FitPlan(plan, {}, {}).ok());
}

TEST(FitMode, NamesAreRead) {
  for (const FitMode mode : {FitMode::kFull, FitMode::kAcg, FitMode::kSimilarity, FitMode::kAffine}) {
    EXPECT_EQ(FitModeFrom(NameOf(mode)), mode);
  }
  EXPECT_EQ(FitModeFrom("best"), std::nullopt);
}

}  // namespace
}  // namespace enfilade::prior
