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

std::vector<LineSides> SidesOf(const std::vector<DoorLine>& lines) {
  const GroundMap ground = ReadGround(Corridor().grid, {}, {});
  std::vector<DoorCandidate> cuts;
  for (const DoorLine& line : lines) cuts.push_back(line.line);
  return SurroundingsOf(ground, CutAlong(ground, DistancesToWalls(ground), cuts), lines);
}

TEST(Surroundings, DoorsThatAreClosedMakeACorridorNoWider) {
  const grid::GridGeometry& geometry = Corridor().grid.geometry;
  const LineSides closed = SidesOf(LinesOf(geometry, -1.0)).front();
  for (const LineSide& side : closed) EXPECT_LT(side.wider, 0.3);
  const LineSides open = SidesOf(LinesOf(geometry, 1.0)).front();
  for (const LineSide& side : open) EXPECT_GT(side.wider, 1.5);
}

TEST(Surroundings, AreThoseOfTheRegionsBesideALine) {
  const std::vector<LineSides> sides = SidesOf(LinesOf(Corridor().grid.geometry, -1.0));
  // Half the corridor on either side, each with two doors, into whose openings the circle reaches.
  for (const LineSide& half : sides[0]) {
    EXPECT_NEAR(half.diameter, 1.5, 0.1);
    EXPECT_NEAR(half.area, 2.5, 0.4);
    EXPECT_NEAR(half.door_share, 2.6 / 6.5, 0.1);
    EXPECT_EQ(half.open_share, 0.0);
  }
  // Half the corridor, with another door and the line across, then the room.
  for (std::size_t door = 1; door < sides.size(); ++door) {
    EXPECT_NEAR(sides[door][0].diameter, 1.5, 0.1);
    EXPECT_NEAR(sides[door][0].door_share, 2.6 / 6.5, 0.1);
    EXPECT_NEAR(sides[door][1].diameter, 1.75, 0.2);
    EXPECT_EQ(sides[door][1].door_share, 0.0);
  }
}

TEST(Surroundings, OfALineWithoutLengthAreNumbers) {
  for (const double value : ValuesOf(DoorLine{}, LineSides{})) EXPECT_TRUE(std::isfinite(value));
}

TEST(Surroundings, ItDoesNotMatterWhichJambIsFirst) {
  std::vector<DoorLine> lines = LinesOf(Corridor().grid.geometry, -1.0);
  const std::vector<LineSides> before = SidesOf(lines);
  for (DoorLine& line : lines) std::swap(line.line.a, line.line.b);
  const std::vector<LineSides> after = SidesOf(lines);
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const SurroundedValues one = ValuesOf(lines[i], before[i]);
    const SurroundedValues other = ValuesOf(lines[i], after[i]);
    for (std::size_t k = 0; k < one.size(); ++k) EXPECT_NEAR(one[k], other[k], 0.11) << k;
  }
}

}  // namespace
}  // namespace enfilade::rooms
