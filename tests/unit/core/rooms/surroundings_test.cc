// SPDX-License-Identifier: Apache-2.0
#include "core/rooms/surroundings.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "tests/unit/core/rooms/drawn_rooms.h"

namespace enfilade::rooms {
namespace {

// A corridor between four rooms with wide doors.
const DrawnRooms& Corridor() {
  static const DrawnRooms drawn({
      "#################", "#       #       #", "#       #       #", "#       #       #", "#       #       #",
      "#       #       #", "#       #       #", "#       #       #", "##     ###     ##", "#               #",
      "#               #", "#               #", "#               #", "#               #", "##     ###     ##",
      "#       #       #", "#       #       #", "#       #       #", "#       #       #", "#       #       #",
      "#       #       #", "#       #       #", "#################",
  });
  return drawn;
}

// The line across the corridor between the doors, then one in each door; m.
std::vector<DoorLine> LinesOf(const grid::GridGeometry& geometry, double openness_of_doors) {
  const auto line = [&](double ax, double ay, double bx, double by, double openness) {
    DoorLine found{{ToCells(geometry, {ax, ay}), ToCells(geometry, {bx, by})}, {}, openness};
    found.evidence.length = found.line.length() * geometry.resolution;
    return found;
  };
  std::vector<DoorLine> lines{line(2.125, 2.225, 2.125, 3.525, -1.0)};
  for (const double left : {0.475, 2.475}) {
    for (const double y : {2.125, 3.625}) lines.push_back(line(left, y, left + 1.3, y, openness_of_doors));
  }
  return lines;
}

std::vector<Surroundings> AroundLines(const std::vector<DoorLine>& lines) {
  const GroundMap ground = ReadGround(Corridor().grid, {}, {});
  std::vector<DoorCandidate> cuts;
  for (const DoorLine& line : lines) cuts.push_back(line.line);
  return SurroundingsOf(ground, CutAlong(ground, DistancesToWalls(ground), cuts), lines);
}

TEST(Surroundings, DoorsThatAreClosedMakeACorridorNoWider) {
  const grid::GridGeometry& geometry = Corridor().grid.geometry;
  const LineSides closed = AroundLines(LinesOf(geometry, -1.0)).front().sides;
  for (const LineSide& side : closed) EXPECT_LT(side.wider, 0.3);
  const LineSides open = AroundLines(LinesOf(geometry, 1.0)).front().sides;
  for (const LineSide& side : open) EXPECT_GT(side.wider, 1.5);
}

TEST(Surroundings, AreThoseOfTheRegionsBesideALine) {
  const std::vector<Surroundings> around = AroundLines(LinesOf(Corridor().grid.geometry, -1.0));
  // Half the corridor on either side, each with two doors, into whose openings the circle reaches.
  for (const LineSide& half : around[0].sides) {
    EXPECT_NEAR(half.diameter, 1.5, 0.1);
    EXPECT_NEAR(half.area, 2.5, 0.4);
    EXPECT_NEAR(half.door_share, 2.6 / 6.5, 0.1);
    EXPECT_EQ(half.open_share, 0.0);
  }
  // Half the corridor, with another door and the line across, then the room.
  for (std::size_t door = 1; door < around.size(); ++door) {
    EXPECT_NEAR(around[door].sides[0].diameter, 1.5, 0.1);
    EXPECT_NEAR(around[door].sides[0].door_share, 2.6 / 6.5, 0.1);
    EXPECT_NEAR(around[door].sides[1].diameter, 1.75, 0.2);
    EXPECT_EQ(around[door].sides[1].door_share, 0.0);
  }
}

TEST(Surroundings, TellWhatWallsPartTheTwoRegions) {
  const std::vector<Surroundings> around = AroundLines(LinesOf(Corridor().grid.geometry, -1.0));
  EXPECT_EQ(around[0].context.parted, 0.0);  // no wall is between the halves of the corridor
  for (std::size_t door = 1; door < around.size(); ++door) {
    EXPECT_NEAR(around[door].context.parted, 0.7, 0.2);  // of the 2 m between a room and its half of the corridor
    EXPECT_NEAR(around[door].context.opened, 1.3, 0.1);
  }
}

TEST(Surroundings, DoorsOfACorridorLieInARow) {
  const std::vector<Surroundings> around = AroundLines(LinesOf(Corridor().grid.geometry, -3.0));
  EXPECT_EQ(around[0].context.row, 0.0);
  for (std::size_t door = 1; door < around.size(); ++door) {
    EXPECT_NEAR(around[door].context.row, 0.95, 0.05);
    EXPECT_GT(around[door].context.alike, 0.6);  // the others and the line across, which is as long
  }
}

TEST(Surroundings, TellWhatTheFirstLookMadeOfTheOtherLines) {
  std::vector<DoorLine> lines = LinesOf(Corridor().grid.geometry, -4.0);  // the line across the corridor: -1
  lines[1].evidence.reports = 2;
  lines[2].evidence.reports = 1;
  lines[0].evidence.silence = 1.0;
  const std::vector<Surroundings> around = AroundLines(lines);
  const double door = 1.0 / (1.0 + std::exp(-4.0));  // the chance of each of the four doors
  const FirstLooks& across = around[0].context.looks;
  EXPECT_EQ(across.own, -1.0);
  EXPECT_DOUBLE_EQ(across.others, -3.0);
  EXPECT_DOUBLE_EQ(across.reported, (2.0 * door + 0.5) / 3.0);
  EXPECT_DOUBLE_EQ(across.silent, 0.5);  // no other line was crossed in silence
  EXPECT_DOUBLE_EQ(across.detected, 2.5 / 5.0);
  EXPECT_DOUBLE_EQ(across.doubtful, 0.5 / 5.0);
  const FirstLooks& reported = around[1].context.looks;
  EXPECT_DOUBLE_EQ(reported.others, -10.0 / 4.0);
  EXPECT_DOUBLE_EQ(reported.reported, (door + 0.5) / 2.0);
  EXPECT_DOUBLE_EQ(reported.detected, 1.5 / 4.0);
  EXPECT_DOUBLE_EQ(reported.doubtful, 1.5 / 5.0);
}

TEST(Surroundings, OfALineWithoutLengthAreNumbers) {
  for (const double value : ValuesOf(DoorLine{}, Surroundings{})) EXPECT_TRUE(std::isfinite(value));
}

TEST(Surroundings, ItDoesNotMatterWhichJambIsFirst) {
  std::vector<DoorLine> lines = LinesOf(Corridor().grid.geometry, -1.0);
  const std::vector<Surroundings> before = AroundLines(lines);
  for (DoorLine& line : lines) std::swap(line.line.a, line.line.b);
  const std::vector<Surroundings> after = AroundLines(lines);
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const SurroundedValues one = ValuesOf(lines[i], before[i]);
    const SurroundedValues other = ValuesOf(lines[i], after[i]);
    for (std::size_t k = 0; k < one.size(); ++k) EXPECT_NEAR(one[k], other[k], 0.11) << k;
  }
}

}  // namespace
}  // namespace enfilade::rooms
