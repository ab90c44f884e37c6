// SPDX-License-Identifier: Apache-2.0
#include "core/rooms/door_odds.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "core/rooms/door_lines.h"
#include "tests/unit/core/rooms/drawn_rooms.h"

namespace enfilade::rooms {
namespace {

std::vector<DoorLine> LinesOf(const DrawnRooms& drawn) {
  const GroundMap ground = ReadGround(drawn.grid, {}, {});
  return FindDoorLines(ground, DistancesToWalls(ground), {}, DoorOdds({}));
}

const DrawnRooms& Door() {
  static const DrawnRooms drawn({
      "#####################",
      "#         #         #",
      "#         #         #",
      "#         #         #",
      "#                   #",
      "#                   #",
      "#                   #",
      "#                   #",
      "#         #         #",
      "#         #         #",
      "#         #         #",
      "#####################",
  });
  return drawn;
}

TEST(DoorOdds, AGapInAWallIsRatherADoor) {
  const std::vector<DoorLine> lines = LinesOf(Door());
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_LT(lines[0].openness, -2.0);
  EXPECT_EQ(lines[0].openness, DoorOdds({}).OpennessOf(lines[0].evidence));
}

TEST(DoorOdds, ItDoesNotMatterWhichJambIsFirst) {
  DoorEvidence evidence = LinesOf(Door()).at(0).evidence;
  evidence.a.slender = 0.4;
  evidence.b.across_behind = 0.3;
  const double openness = DoorOdds({}).OpennessOf(evidence);
  std::swap(evidence.a, evidence.b);
  EXPECT_EQ(DoorOdds({}).OpennessOf(evidence), openness);
}

TEST(DoorOdds, ItDoesNotMatterOnWhichSideTheWallsRunAcross) {
  DoorEvidence evidence = LinesOf(Door()).at(0).evidence;
  evidence.a.across_before = 0.9;
  evidence.a.across_behind = 0.1;
  evidence.b.across_before = 0.6;
  evidence.b.across_behind = 0.2;
  const DoorValues values = ValuesOf(evidence);
  std::swap(evidence.a.across_before, evidence.a.across_behind);
  std::swap(evidence.b.across_before, evidence.b.across_behind);
  EXPECT_EQ(ValuesOf(evidence), values);
  // But it matters whether they run on the same side of both jambs.
  std::swap(evidence.a.across_before, evidence.a.across_behind);
  EXPECT_NE(ValuesOf(evidence), values);
}

TEST(DoorOdds, AreOthersWhereRobotsReportedPassages) {
  const std::vector<PassageHint> passages(1);
  const DoorOdds driven(RoomEvidence{passages, {}});
  const DoorLine line = LinesOf(Door()).at(0);
  EXPECT_LT(driven.OpennessOf(line.evidence), -2.0);
  EXPECT_NE(driven.OpennessOf(line.evidence), DoorOdds({}).OpennessOf(line.evidence));
  const SurroundedValues values = ValuesOf(line, Surroundings{});
  EXPECT_NE(driven.OpennessOf(values), DoorOdds({}).OpennessOf(values));
}

TEST(DoorOdds, AWideOpeningBetweenShortWallsIsRatherOpen) {
  const DrawnRooms drawn({
      "#####################",
      "#         #         #",
      "#                   #",
      "#                   #",
      "#                   #",
      "#                   #",
      "#                   #",
      "#                   #",
      "#                   #",
      "#                   #",
      "#                   #",
      "#         #         #",
      "#####################",
  });
  for (const DoorLine& line : LinesOf(drawn)) EXPECT_GT(line.openness, 0.0) << line.evidence.width;
}

TEST(DoorOdds, ALineBetweenJambsThatAreNotOppositeFollowsTheWall) {
  // The right wall begins half a metre farther up than the left one ends: the shortest line is oblique.
  const DrawnRooms drawn({
      "#####################",
      "#                   #",
      "#                   #",
      "#                   #",
      "#                   #",
      "#                   #",
      "#                   #",
      "#            ########",
      "#                   #",
      "##########          #",
      "#                   #",
      "#                   #",
      "#                   #",
      "#                   #",
      "#                   #",
      "#####################",
  });
  const GroundMap ground = ReadGround(drawn.grid, {}, {});
  const DoorCandidate oblique{{49.0, 32.0}, {65.0, 42.0}};
  const std::vector<DoorCandidate> aligned = AlignWithWalls(ground, oblique, 112.0);
  ASSERT_FALSE(aligned.empty());
  for (const DoorCandidate& line : aligned) {
    const Eigen::Vector2d along = line.b - line.a;
    EXPECT_LT(std::min(std::abs(along.x()), std::abs(along.y())), 2.0) << along.transpose();
  }
}

}  // namespace
}  // namespace enfilade::rooms
