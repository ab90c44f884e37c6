// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/campus/random_building.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numeric>
#include <set>
#include <string>
#include <vector>

#include "client/simulator/route_driver.h"
#include "client/simulator/world/world.h"
#include "tests/support/status_assertions.h"

namespace enfilade::simulator {
namespace {

constexpr std::uint64_t kSeeds = 50;

double DistanceToEdge(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d edge = b - a;
  const double t = std::clamp((p - a).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
  return (p - a - t * edge).norm();
}

// Whether both ends of the door lie on one and the same edge of the outline.
bool LiesInAWallOf(const Door& door, const Area& area) {
  for (std::size_t i = 0; i < area.outline.size(); ++i) {
    const Eigen::Vector2d& p = area.outline[i];
    const Eigen::Vector2d& q = area.outline[(i + 1) % area.outline.size()];
    if (DistanceToEdge(door.a, p, q) < 1e-6 && DistanceToEdge(door.b, p, q) < 1e-6) return true;
  }
  return false;
}

// The areas on the two sides of a door's middle.
std::vector<std::string> AreasBeside(const Campus& campus, const Door& door) {
  const Eigen::Vector2d edge = (door.b - door.a).normalized();
  const Eigen::Vector2d normal(-edge.y(), edge.x());
  std::vector<std::string> areas;
  for (const double side : {-0.3, 0.3}) {
    const Area* area = campus.AreaAt(door.level, door.middle() + side * normal);
    if (area) areas.push_back(area->id);
  }
  return areas;
}

class RandomBuildings : public ::testing::TestWithParam<std::uint64_t> {
 protected:
  const Campus campus_ = RandomBuilding(GetParam());
};

TEST_P(RandomBuildings, AreValidAndTheSameForTheSameSeed) {
  ASSERT_OK(Validate(campus_));
  const Campus again = RandomBuilding(GetParam());
  ASSERT_EQ(again.doors.size(), campus_.doors.size());
  for (std::size_t i = 0; i < again.doors.size(); ++i) {
    EXPECT_EQ(again.doors[i].a, campus_.doors[i].a);
    EXPECT_EQ(again.doors[i].state, campus_.doors[i].state);
  }
  ASSERT_EQ(again.boxes.size(), campus_.boxes.size());
  for (std::size_t i = 0; i < again.boxes.size(); ++i) EXPECT_EQ(again.boxes[i].outline, campus_.boxes[i].outline);
  ASSERT_EQ(again.robots[0].route.size(), campus_.robots[0].route.size());
  for (std::size_t i = 0; i < again.robots[0].route.size(); ++i) {
    EXPECT_EQ(again.robots[0].route[i].point, campus_.robots[0].route[i].point);
  }
}

TEST_P(RandomBuildings, HaveTheirDoorsInWallsBetweenTwoAreas) {
  const BuildingOptions options;
  for (const Door& door : campus_.doors) {
    EXPECT_TRUE(std::any_of(campus_.areas.begin(), campus_.areas.end(), [&](const Area& area) {
      return LiesInAWallOf(door, area);
    })) << door.id;
    if (door.opening) continue;  // a pane of glass beside a door
    const std::vector<std::string> beside = AreasBeside(campus_, door);
    ASSERT_EQ(beside.size(), 2U) << door.id;
    EXPECT_NE(beside[0], beside[1]) << door.id;
    EXPECT_GE(door.width(), options.min_width - 1e-9) << door.id;
    EXPECT_LE(door.width(), options.max_width + 1e-9) << door.id;
    if (door.leaf) {
      EXPECT_EQ(door.state, DoorState::kOpen) << door.id;
      EXPECT_GT(std::abs(*door.leaf), 1.5) << door.id;
    }
  }
}

// With all doors open each area can be reached from each other one.
TEST_P(RandomBuildings, HaveNoAreaWithoutADoor) {
  std::map<std::string, std::string> leader;
  for (const Area& area : campus_.areas) leader[area.id] = area.id;
  const auto find = [&](std::string id) {
    while (leader[id] != id) id = leader[id];
    return id;
  };
  for (const Door& door : campus_.doors) {
    if (door.opening) continue;
    const std::vector<std::string> beside = AreasBeside(campus_, door);
    if (beside.size() == 2) leader[find(beside[0])] = find(beside[1]);
  }
  for (const Area& area : campus_.areas) EXPECT_EQ(find(area.id), find("corridor")) << area.id;
}

TEST_P(RandomBuildings, HaveAreasThatDoNotOverlap) {
  for (const Area& area : campus_.areas) {
    for (std::size_t i = 0; i < area.outline.size(); ++i) {
      const Eigen::Vector2d middle =
          std::accumulate(area.outline.begin(), area.outline.end(), Eigen::Vector2d(0.0, 0.0)) /
          static_cast<double>(area.outline.size());
      const Eigen::Vector2d inside = area.outline[i] + 0.05 * (middle - area.outline[i]);
      const auto holders = std::count_if(campus_.areas.begin(), campus_.areas.end(),
                                         [&](const Area& other) { return simulator::Contains(other.outline, inside); });
      EXPECT_EQ(holders, 1) << area.id << " corner " << i;
    }
  }
}

TEST_P(RandomBuildings, KeepTheRouteFreeOfFurnitureAndInsideAreas) {
  const std::vector<RouteStep>& route = campus_.robots[0].route;
  ASSERT_GE(route.size(), 2U);
  for (std::size_t i = 1; i < route.size(); ++i) {
    const Eigen::Vector2d leg = route[i].point - route[i - 1].point;
    const int pieces = 1 + static_cast<int>(leg.norm() / 0.2);
    for (int k = 0; k <= pieces; ++k) {
      const Eigen::Vector2d at = route[i - 1].point + leg * (static_cast<double>(k) / pieces);
      // Between two areas the point itself may belong to neither, by rounding.
      const Eigen::Vector2d beside = at + 1e-6 * leg;
      EXPECT_TRUE(campus_.AreaAt("ground", at) || campus_.AreaAt("ground", beside)) << "leg " << i;
      for (const Box& box : campus_.boxes) EXPECT_FALSE(simulator::Contains(box.outline, at)) << "leg " << i;
    }
  }
}

// How many open doors the robot passes on its whole drive; a route that runs into something fails.
int DriveThrough(const std::shared_ptr<const World>& world, const std::string& id, int laps) {
  Robot robot = *world->campus().FindRobot(id);
  robot.laps = laps;
  RouteDriver driver(world, robot, {}, 0.05);
  int passed = 0;
  std::string area;
  while (true) {
    const auto step = driver.Next();
    EXPECT_OK(step) << id;
    if (!step.ok() || !*step) return passed;
    const Area* here = world->campus().AreaAt("ground", driver.T_campus_robot().translation());
    if (!here) continue;
    passed += !area.empty() && here->id != area ? 1 : 0;
    area = here->id;
  }
}

TEST_P(RandomBuildings, AreDrivenByTwoRobotsForTwoLaps) {
  const auto world = std::make_shared<const World>(campus_);
  ASSERT_EQ(campus_.robots.size(), 2U);
  EXPECT_GE(DriveThrough(world, "robot", 2), 2 * static_cast<int>(campus_.robots[0].route.size() > 2));
  EXPECT_GE(DriveThrough(world, "robot2", 2), 2);
  const Area* first = campus_.AreaAt("ground", campus_.robots[0].route[0].point);
  const Area* second = campus_.AreaAt("ground", campus_.robots[1].route[0].point);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->id, second->id) << "both start in one area";
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomBuildings, ::testing::Range<std::uint64_t>(0, kSeeds));

TEST(RandomBuilding, DiffersFromSeedToSeed) {
  std::set<double> thicknesses;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) thicknesses.insert(RandomBuilding(seed).wall_thickness);
  EXPECT_EQ(thicknesses.size(), kSeeds);
}

TEST(RandomBuilding, HasAllKindsOfDoorsAmongManySeeds) {
  int closed = 0;
  int glass = 0;
  int leaves = 0;
  int panes = 0;
  int people = 0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const Campus campus = RandomBuilding(seed);
    people += static_cast<int>(campus.people.size());
    for (const Door& door : campus.doors) {
      panes += door.opening ? 1 : 0;
      closed += door.state == DoorState::kClosed ? 1 : 0;
      glass += !door.opening && door.state == DoorState::kGlass ? 1 : 0;
      leaves += door.leaf ? 1 : 0;
    }
  }
  for (const int count : {closed, glass, leaves, panes, people}) EXPECT_GT(count, 5);
}

// Figures that were measured in these buildings stay comparable.
TEST(RandomBuilding, StaysTheSameFromVersionToVersion) {
  const Campus campus = RandomBuilding(8101);
  ASSERT_GT(campus.boxes.size(), 3U);
  EXPECT_NEAR(campus.robots[0].route.back().point.x(), 3.6786083250901975, 1e-6);
  EXPECT_NEAR(campus.boxes.back().outline[0].y(), 3.1356033941648978, 1e-6);
}

TEST(RandomBuilding, FollowsItsOptions) {
  BuildingOptions bare;
  bare.clutter = bare.people = bare.narrows = bare.leaf = bare.glass_panel = 0.0;
  bare.passages = 3;
  bare.min_width = bare.max_width = 1.1;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const Campus campus = RandomBuilding(seed, bare);
    EXPECT_TRUE(campus.boxes.empty());
    EXPECT_LE(campus.robots[0].route.size(), 1U + 3U * 3U);
    for (const Door& door : campus.doors) {
      EXPECT_NEAR(door.width(), 1.1, 1e-9);
      EXPECT_FALSE(door.leaf);
      EXPECT_FALSE(door.opening);
    }
  }
}

}  // namespace
}  // namespace enfilade::simulator
