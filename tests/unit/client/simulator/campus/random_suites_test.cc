// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/campus/random_suites.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>

#include "tests/support/status_assertions.h"
#include "tests/unit/client/simulator/campus/generated_campus.h"

namespace enfilade::simulator {
namespace {

constexpr std::uint64_t kSuiteSeeds = 30;

// Whether a jamb stands at the face of a wall that runs across the door's line: at a corner of an area.
bool IsFlush(const Campus& campus, const Door& door) {
  const double reach = campus.wall_thickness / 2.0 + 1e-6;
  for (const Area& area : campus.areas) {
    for (const Eigen::Vector2d& corner : area.outline) {
      if ((corner - door.a).norm() <= reach || (corner - door.b).norm() <= reach) return true;
    }
  }
  return false;
}

class RandomSuitesTest : public ::testing::TestWithParam<std::uint64_t> {
 protected:
  const absl::StatusOr<Campus> campus_ = RandomSuites(GetParam());
};

TEST_P(RandomSuitesTest, AreValidAndTheSameForTheSameSeed) {
  ASSERT_OK(campus_);
  ASSERT_OK(Validate(*campus_));
  ASSERT_OK_AND_ASSIGN(const Campus again, RandomSuites(GetParam()));
  ASSERT_EQ(again.doors.size(), campus_->doors.size());
  for (std::size_t i = 0; i < again.doors.size(); ++i) EXPECT_EQ(again.doors[i].a, campus_->doors[i].a);
  ASSERT_EQ(again.boxes.size(), campus_->boxes.size());
  for (std::size_t i = 0; i < again.boxes.size(); ++i) EXPECT_EQ(again.boxes[i].outline, campus_->boxes[i].outline);
}

TEST_P(RandomSuitesTest, HaveDoorsBetweenTwoAreas) {
  ASSERT_OK(campus_);
  ExpectDoorsBetweenTwoAreas(*campus_);
  for (const Door& door : campus_->doors) EXPECT_GE(door.width(), 0.75 - 1e-9) << door.id;
}

TEST_P(RandomSuitesTest, LetTheRobotIntoNearlyAllAreasAndBack) {
  ASSERT_OK(campus_);
  ExpectATourThroughMostAreas(*campus_, "corridor");
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomSuitesTest, ::testing::Range<std::uint64_t>(1, kSuiteSeeds + 1));

TEST(RandomSuites, HaveWhatTheyPromiseAmongManySeeds) {
  std::map<std::string, int> count;
  for (std::uint64_t seed = 1; seed <= kSuiteSeeds; ++seed) {
    ASSERT_OK_AND_ASSIGN(const Campus campus, RandomSuites(seed));
    for (const Area& area : campus.areas) {
      count["bathrooms"] += area.id.ends_with("-bathroom") ? 1 : 0;
      count["stores"] += area.id.ends_with("-store") ? 1 : 0;
      count["rooms beside a branch"] += area.id.ends_with("-a") || area.id.ends_with("-b") ? 1 : 0;
    }
    for (const Door& door : campus.doors) {
      count[IsFlush(campus, door) ? "flush" : "not flush"] += 1;
      count["leaves"] += door.leaf ? 1 : 0;
      count["closed"] += door.state == DoorState::kClosed ? 1 : 0;
      count["double doors"] += door.width() > 1.8 ? 1 : 0;
    }
    count["branches"] += static_cast<int>(campus.FindArea("corridor")->outline.size() - 4) / 4;
    count["partitions"] += static_cast<int>(campus.walls.size());
    count["boxes"] += static_cast<int>(campus.boxes.size());
    EXPECT_TRUE(campus.people.empty());
  }
  for (const auto& [what, number] : count) EXPECT_GT(number, 10) << what;
  EXPECT_EQ(count.size(), 11U);
  EXPECT_GT(3 * count["flush"], count["not flush"]);
}

// Figures that were measured in these buildings stay comparable.
TEST(RandomSuites, StayTheSameFromVersionToVersion) {
  ASSERT_OK_AND_ASSIGN(const Campus campus, RandomSuites(2001));
  ASSERT_GT(campus.boxes.size(), 3U);
  EXPECT_NEAR(campus.doors.back().a.y(), 0.86429233232434666, 1e-6);
  EXPECT_NEAR(campus.boxes.back().outline[0].x(), 18.404247082532478, 1e-6);
}

}  // namespace
}  // namespace enfilade::simulator
