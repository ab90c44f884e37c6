// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/campus/random_halls.h"

#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <string>
#include <vector>

#include "core/geometry/segments.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/client/simulator/campus/generated_campus.h"

namespace enfilade::simulator {
namespace {

constexpr std::uint64_t kHallSeeds = 30;

class RandomHallsTest : public ::testing::TestWithParam<std::uint64_t> {
 protected:
  const absl::StatusOr<Campus> campus_ = RandomHalls(GetParam());
};

// m, from a wall of the hall to the nearest outline, wall or box that it does not stand at.
double WayAround(const Campus& campus, const Wall& wall) {
  double nearest = std::numeric_limits<double>::infinity();
  const auto compare = [&](const std::vector<Eigen::Vector2d>& points, bool closed) {
    for (std::size_t i = closed ? 0 : 1; i < points.size(); ++i) {
      const Eigen::Vector2d& from = points[i == 0 ? points.size() - 1 : i - 1];
      for (std::size_t k = 1; k < wall.points.size(); ++k) {
        const double distance = SegmentDistance(wall.points[k - 1], wall.points[k], from, points[i]);
        if (distance > 0.06) nearest = std::min(nearest, distance);  // else it stands at it
      }
    }
  };
  for (const Area& area : campus.areas) {
    if (area.id == "hall" || area.id.starts_with("kiosk")) compare(area.outline, true);
  }
  for (const Wall& other : campus.walls) {
    if (&other != &wall) compare(other.points, false);
  }
  for (const Box& box : campus.boxes) {
    if (campus.AreaAt("ground", box.outline[0])->id == "hall") compare(box.outline, true);
  }
  return nearest;
}

TEST_P(RandomHallsTest, AreValidAndTheSameForTheSameSeed) {
  ASSERT_OK(campus_);
  ASSERT_OK(Validate(*campus_));
  ASSERT_OK_AND_ASSIGN(const Campus again, RandomHalls(GetParam()));
  ASSERT_EQ(again.walls.size(), campus_->walls.size());
  for (std::size_t i = 0; i < again.walls.size(); ++i) EXPECT_EQ(again.walls[i].points, campus_->walls[i].points);
}

TEST_P(RandomHallsTest, HaveDoorsBetweenTwoAreas) {
  ASSERT_OK(campus_);
  ExpectDoorsBetweenTwoAreas(*campus_);
}

TEST_P(RandomHallsTest, LeaveAWayAroundEachWall) {
  ASSERT_OK(campus_);
  for (const Wall& wall : campus_->walls) EXPECT_GT(WayAround(*campus_, wall), 0.65);
}

TEST_P(RandomHallsTest, LetTheRobotIntoTheHallAndRoomsAndBack) {
  ASSERT_OK(campus_);
  ExpectATourThroughMostAreas(*campus_, "hall");
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomHallsTest, ::testing::Range<std::uint64_t>(1, kHallSeeds + 1));

TEST(RandomHalls, HaveWhatTheyPromiseAmongManySeeds) {
  std::map<std::string, int> count;
  for (std::uint64_t seed = 1; seed <= kHallSeeds; ++seed) {
    ASSERT_OK_AND_ASSIGN(const Campus campus, RandomHalls(seed));
    for (const Area& area : campus.areas) {
      const std::string kind = area.id.substr(0, area.id.find('-'));
      count[kind] += 1;
      if (kind == "room" && area.outline.size() > 4) count["round fronts"] += 1;
    }
    for (const Door& door : campus.doors) count["double doors"] += door.width() > 1.8 ? 1 : 0;
    for (const Wall& wall : campus.walls) {
      const std::vector<Eigen::Vector2d>& hall = campus.FindArea("hall")->outline;
      bool at_side = false;
      for (std::size_t i = 0; i < hall.size(); ++i) {
        at_side |= DistanceToSegment(wall.points.front(), hall[i], hall[(i + 1) % hall.size()]) < 0.06;
      }
      const std::string kind = at_side ? "spurs" : wall.points.size() == 4 ? "booths" : "screens";
      count[kind + (wall.points.size() == 3 ? " with a corner" : "")] += 1;
    }
    for (const Box& box : campus.boxes) count[box.top == 3.0 ? "pillars" : "furniture"] += 1;
  }
  for (const char* what : {"hall", "room", "kiosk", "round fronts", "double doors", "screens", "screens with a corner",
                           "spurs", "spurs with a corner", "booths", "pillars", "furniture"}) {
    EXPECT_GT(count[what], 2) << what;
  }
}

// Figures that were measured in these buildings stay comparable.
TEST(RandomHalls, StayTheSameFromVersionToVersion) {
  ASSERT_OK_AND_ASSIGN(const Campus campus, RandomHalls(2001));
  ASSERT_GT(campus.walls.size(), 1U);
  EXPECT_NEAR(campus.doors.back().a.y(), 5.5951522936822276, 1e-6);
  EXPECT_NEAR(campus.walls.back().points[0].x(), 13.86564932172144, 1e-6);
}

}  // namespace
}  // namespace enfilade::simulator
