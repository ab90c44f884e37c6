// SPDX-License-Identifier: Apache-2.0
// What a robot takes for a door ahead of it stays a candidate only as long as it may be one.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/e2e/campus/campus_run.h"

namespace enfilade::testing {
namespace {

// The wall behind the gap is so near that a door in it might be what the robot has seen, if its report did not say
// where the gap is.
constexpr const char* kFurnishedRoom = R"(# A robot sees a gap between two boxes, turns round, and leaves by the door.
campus: furnished-room
areas:
  - id: room
    rect: [0, 0, 6.1, 6]
    doors:
      - {id: door, side: east, at: 1.2, width: 1.0}
  - {id: next, rect: [6.1, 0, 5, 5]}
boxes:
  - {rect: [5, 2.1, 0.4, 1.4], height: 1.5}
  - {rect: [5, 4.5, 0.4, 1.5], height: 1.5}
robots:
  - id: robot
    route:
      - [1.5, 3.0]
      - [4.2, 3.9]
      - {wait: 1}
      - [1.5, 2.2]
      - [2.0, 1.1]
      - [5.0, 1.2]
      - {door: door}
      - [9.0, 2.0]
      - {wait: 1}
)";

TEST(Candidate, AtAGapBetweenFurnitureItIsRemoved) {
  WholeSystem system({});
  const std::filesystem::path campus = system.directory() / "furnished-room.yaml";
  std::ofstream(campus) << kFurnishedRoom;
  CampusRun run;
  run.campus = campus.string();
  run.image_hz = 0.0;
  run.cloud_hz = 0.0;
  const CampusResult result = RunCampus(system, run);
  const std::string made = system.Query("SELECT count(*) FROM enfilade.door_verdicts WHERE site_id = '" + result.site +
                                        "' AND decision = 1");
  EXPECT_EQ(made, "1") << "the robot has seen a door ahead";
  EXPECT_TRUE(result.comparison.exact) << ::testing::PrintToString(result.comparison.wrong);
}

}  // namespace
}  // namespace enfilade::testing
