// SPDX-License-Identifier: Apache-2.0
// A robot that rides in a lift again and again: the cabin is one map, whichever level it is entered from.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/e2e/campus/campus_run.h"

namespace enfilade::testing {
namespace {

constexpr const char* kTwoFloors = R"(# Two floors above each other with a lift between them.
campus: two-floors
levels: {ground: 0, first: 3.5}
lifts:
  - {id: lift, rect: [14.2, 3.8, 2.6, 2.4], side: west, width: 1.0, levels: [ground, first]}
areas:
  - id: foyer
    rect: [0, 0, 14.2, 10]
    doors:
      - {id: entrance, side: west, at: 5, width: 1.4}
  - {id: yard, kind: outdoor, rect: [-20, -4, 20, 18], walls: true, height: 1.6}
  - {id: gallery, level: first, rect: [0, 0, 14.2, 10]}
  - id: office
    level: first
    rect: [0, 10, 8, 5]
    doors:
      - {id: office-door, side: south, at: 4, width: 0.9, leaf_deg: 100}
walls:
  - {points: [[5, 3], [9, 3]], glass: true}
boxes:
  - {rect: [2, 7.5, 2.5, 1.2], height: 1.1}
  - {rect: [11, 0.4, 1.6, 0.8], height: 0.8}
  - {level: first, rect: [5, 4, 3, 1.4], height: 0.75}
  - {level: first, rect: [0.4, 1, 0.6, 3], height: 2.0}
  - {level: first, rect: [1, 13, 1.6, 0.8], height: 0.75}
pillars:
  - {at: [-8, 3], radius: 0.3}
  - {at: [-13, 9], radius: 0.4}
  - {at: [8, 7], radius: 0.25}
people:
  - {path: [[3, 2], [11, 2]], speed: 0.8}
robots:
  - id: r1
    route:
      - [-10, 5.5]
      - [-4, 5]
      - {door: entrance}
      - [6, 5]
      - [12.5, 4.9]
      - {door: lift/ground}
      - {lift: lift, to: first}
      - {door: lift/first}
      - [9.5, 7.5]
      - [4, 8]
      - {door: office-door}
      - [4.5, 12.5]
      - {door: office-door}
      - [4, 8]
      - [9.5, 7.5]
      - [12.5, 4.9]
      - {door: lift/first}
      - {lift: lift, to: ground}
      - {door: lift/ground}
      - [9, 6]
      - [6, 5]
      - [12.5, 4.9]
      - {door: lift/ground}
      - {lift: lift, to: first}
      - {door: lift/first}
      - [9.5, 7.5]
)";

TEST(Lift, RiddenAgainAndAgainItIsOneMapWithADoorOnEachLevel) {
  WholeSystem system({});
  const std::filesystem::path campus = system.directory() / "two-floors.yaml";
  std::ofstream(campus) << kTwoFloors;
  CampusRun run;
  run.campus = campus.string();
  run.image_hz = 0.0;
  run.cloud_hz = 0.0;
  const Comparison comparison = RunCampus(system, run).comparison;
  EXPECT_EQ(comparison.areas, 5);
  EXPECT_EQ(comparison.maps, 5) << ::testing::PrintToString(comparison.wrong);
  EXPECT_EQ(comparison.maps_extra, 0);
  EXPECT_EQ(comparison.areas_missing, 0);
  EXPECT_EQ(comparison.doors, 4);
  EXPECT_EQ(comparison.joins, 4) << ::testing::PrintToString(comparison.wrong);
  EXPECT_EQ(comparison.joins_false, 0);
  EXPECT_EQ(comparison.components, 1);
  EXPECT_EQ(comparison.false_placements, 0);
  EXPECT_TRUE(comparison.exact) << ::testing::PrintToString(comparison.wrong);
}

// Three levels of Open-RMF's hotel. With this seed the robot's detector misses the way out of the lift on the second.
TEST(Lift, LevelsStayApartIfTheWayOutOfTheLiftIsMissed) {
  ENFILADE_RECORDING_OR_SKIP(hotel, "maps/rmf_demos/hotel.building.yaml");
  WholeSystem system({});
  CampusRun run;
  run.campus = hotel.string();
  run.seed = 51;
  run.image_hz = 0.0;
  run.cloud_hz = 0.0;
  const Comparison comparison = RunCampus(system, run).comparison;
  EXPECT_EQ(comparison.areas, 50);
  EXPECT_EQ(comparison.components, 1);
  EXPECT_EQ(comparison.false_placements, 0);
  // Rooms of two levels in one map show as many missing ones.
  EXPECT_LE(comparison.areas_missing, 1) << ::testing::PrintToString(comparison.wrong);
  EXPECT_LE(comparison.maps_extra, 1) << ::testing::PrintToString(comparison.wrong);
  EXPECT_LE(comparison.joins_wrong, 1) << ::testing::PrintToString(comparison.wrong);
}

}  // namespace
}  // namespace enfilade::testing
