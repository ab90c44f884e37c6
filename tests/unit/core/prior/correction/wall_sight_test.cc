// SPDX-License-Identifier: Apache-2.0
#include "core/prior/correction/wall_sight.h"

#include <gtest/gtest.h>

#include "tests/support/plans/drawn_building.h"

namespace enfilade::prior {
namespace {

// The building as a robot has mapped it, and a plan of it with one more wall.
class WallSightTest : public testing::Test {
 protected:
  WallSight SightWith(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    PlanGraph plan = built_;
    const int first = static_cast<int>(plan.corners.size());
    plan.corners.push_back({20 * from});
    plan.corners.push_back({20 * to});
    plan.walls.push_back({.from = first, .to = first + 1});
    const std::vector<WallFace> faces = Transformed(FacesOf(plan), place_);
    std::vector<WallFace> lines;
    for (std::size_t i = 0; i < plan.walls.size(); ++i) {
      const PlanWall& wall = plan.walls[i];
      lines.push_back({place_(plan.corners[static_cast<std::size_t>(wall.from)].point),
                       place_(plan.corners[static_cast<std::size_t>(wall.to)].point),
                       static_cast<int>(i),
                       {}});
    }
    sights_ = SightsOf(lines, faces, evidence_);
    return sights_.back();
  }

  const PlanGraph built_ = DrawnBuilding();
  const PlanTransform place_{Eigen::Vector2d(0.05, -0.05).asDiagonal(), {1, 30}};
  MapEvidence evidence_ = EvidenceOf(MapOf(
      built_, [&](const Eigen::Vector2d& p) { return place_(p); },
      [](const Eigen::Vector2d& sheet) { return sheet.x() < 600; }));
  std::vector<WallSight> sights_;
};

TEST_F(WallSightTest, WallsThatTheMapHasAreSeen) {
  SightWith({8, 2}, {8, 5});
  for (std::size_t i = 0; i < built_.walls.size(); ++i) {
    const Eigen::Vector2d from = built_.corners[static_cast<std::size_t>(built_.walls[i].from)].point;
    const Eigen::Vector2d to = built_.corners[static_cast<std::size_t>(built_.walls[i].to)].point;
    if (from.x() < 590 && to.x() < 590) {
      EXPECT_EQ(sights_[i].sight, Sight::kSeen) << i;
      EXPECT_GT(sights_[i].seen_share, 0.8) << i;
    }
    if (from.x() > 610 && to.x() > 610) {
      EXPECT_EQ(sights_[i].sight, Sight::kUnseen) << i;
    }
  }
}

// A metre long: nearly half of it is near the wall where it begins.
TEST_F(WallSightTest, AShortWallThatIsNotThereIsContradicted) {
  const WallSight sight = SightWith({8.5, 0}, {8.5, 1});
  EXPECT_EQ(sight.sight, Sight::kContradicted);
  EXPECT_GT(sight.contradicted_share, 0.7);
}

// Beside a real one, which belongs to another wall of the plan: it cannot be that wall, but the map may be off.
TEST_F(WallSightTest, AWallThatIsDrawnTwiceIsSeenOnce) {
  const WallSight sight = SightWith({12.3, 1}, {12.3, 9});
  EXPECT_LT(sight.seen_share, 0.2);
  EXPECT_EQ(sight.sight, Sight::kUnseen);
}

// Furniture stands along a third of it; one sees through the rest.
TEST_F(WallSightTest, AWallBesideFurnitureIsNotSeen) {
  PlanGraph furnished = built_;
  for (const double y : {120.0, 140.0}) DrawWall(furnished, {360, y}, {380, y});
  for (const double x : {360.0, 380.0}) DrawWall(furnished, {x, 120}, {x, 140});
  evidence_ = EvidenceOf(MapOf(furnished, place_, [](const Eigen::Vector2d&) { return true; }));
  const WallSight sight = SightWith({18.05, 5.8}, {18.05, 9});
  EXPECT_EQ(sight.sight, Sight::kContradicted);
  EXPECT_EQ(sight.seen_share, 0);
}

TEST_F(WallSightTest, NothingIsKnownOfWallsWhereNoRobotHasBeen) {
  const WallSight sight = SightWith({38, 2}, {38, 9});
  EXPECT_EQ(sight.seen_share, 0);
  EXPECT_EQ(sight.contradicted_share, 0);
}

}  // namespace
}  // namespace enfilade::prior
