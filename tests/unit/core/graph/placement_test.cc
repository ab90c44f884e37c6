// SPDX-License-Identifier: Apache-2.0
#include "core/graph/placement.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <string>

#include "tests/support/pose_matchers.h"

namespace enfilade::graph {
namespace {

using ::enfilade::testing::PoseNear;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr double kQuarter = M_PI / 2;

Eigen::Matrix3d Variance(double position, double yaw = 0.0) {
  return Eigen::Vector3d(position, position, yaw).asDiagonal();
}

Anchor At(const std::string& map, const Pose2& pose, double variance = 0.01) {
  return {MapId(map), pose, Variance(variance, variance)};
}

LinkPoint Join(const std::string& id, std::vector<Anchor> anchors, LinkPointUse use = LinkPointUse::kUsed) {
  LinkPoint link_point;
  link_point.id = LinkPointId(id);
  link_point.anchors = std::move(anchors);
  link_point.use = use;
  return link_point;
}

// Feeds all of `link_points` as the store does: first `changed`, then those at the maps that were reached.
void PlaceAll(Placement& placement, const std::map<MapId, PoseWithCovariance>& known,
              const std::vector<LinkPoint>& link_points, const LinkPoint& changed) {
  std::vector<LinkPoint> next = {changed};
  while (!next.empty()) {
    for (const MapId& map : placement.UnknownMapsOf(next)) {
      const auto place = known.find(map);
      if (place != known.end()) placement.SetPlace(map, place->second);
    }
    const std::vector<MapId> reached = placement.Visit(next);
    next.clear();
    for (const LinkPoint& link_point : link_points) {
      const bool joins = std::any_of(reached.begin(), reached.end(),
                                     [&](const MapId& map) { return link_point.FindAnchor(map) != nullptr; });
      if (joins) next.push_back(link_point);
    }
  }
}

TEST(PlacementTest, ALinkPointLiesWhereItsPlacedMapSeesIt) {
  Placement placement;
  placement.SetPlace(MapId("hall"), {{1, 2, kQuarter}, Variance(0.0)});
  EXPECT_THAT(placement.Visit(std::vector{Join("candidate", {At("hall", {3, 0, 0.5})})}), IsEmpty());
  ASSERT_THAT(placement.link_points(), SizeIs(1));
  EXPECT_THAT(placement.link_points().at(LinkPointId("candidate")).pose,
              PoseNear(Pose2{1, 5, kQuarter + 0.5}, 1e-12, 1e-12));
  EXPECT_THAT(placement.maps(), IsEmpty());
}

TEST(PlacementTest, WithoutAPlacedMapNothingHappens) {
  Placement placement;
  const std::vector<LinkPoint> door = {Join("door", {At("b", {}), At("a", {})})};
  EXPECT_THAT(placement.UnknownMapsOf(door), ElementsAre(MapId("a"), MapId("b")));
  EXPECT_THAT(placement.Visit(door), IsEmpty());
  EXPECT_THAT(placement.link_points(), IsEmpty());
  EXPECT_THAT(placement.maps(), IsEmpty());
}

TEST(PlacementTest, ADoorPlacesTheMapBehindIt) {
  Placement placement;
  placement.SetPlace(MapId("hall"), {});
  const std::vector<LinkPoint> door = {Join("door", {At("lab", {0, 0, 0}), At("hall", {10, 0, kQuarter})})};
  EXPECT_THAT(placement.UnknownMapsOf(door), ElementsAre(MapId("lab")));
  EXPECT_THAT(placement.Visit(door), ElementsAre(MapId("lab")));
  ASSERT_THAT(placement.maps(), SizeIs(1));
  EXPECT_EQ(placement.maps()[0].first, MapId("lab"));
  EXPECT_THAT(placement.maps()[0].second.pose, PoseNear(Pose2{10, 0, kQuarter}, 1e-12, 1e-12));
  // Both anchors are uncertain: so is the way through.
  EXPECT_NEAR(placement.maps()[0].second.covariance(0, 0), 0.02, 1e-12);
  EXPECT_THAT(placement.UnknownMapsOf(door), IsEmpty());
}

TEST(PlacementTest, TakesTheAnchorThatLeavesTheLeastUncertainPosition) {
  const LinkPoint lift = Join("lift", {At("a", {0, 0, 0}, 0.5), At("b", {0, 0, 0}, 0.1), At("c", {0, 0, 0}, 0.2)});
  Placement placement;
  placement.SetPlace(MapId("a"), {{100, 0, 0}, Variance(0.0)});
  placement.SetPlace(MapId("b"), {{200, 0, 0}, Variance(0.3)});
  placement.SetPlace(MapId("c"), {{300, 0, 0}, Variance(0.0)});
  placement.Visit(std::vector{lift});
  EXPECT_EQ(placement.link_points().at(lift.id).pose.x, 300.0);  // 0.2, before 0.4 and 0.5
}

TEST(PlacementTest, OfEquallyGoodAnchorsTheFirstCounts) {
  Placement placement;
  placement.SetPlace(MapId("a"), {{100, 0, 0}, Variance(0.1)});
  placement.SetPlace(MapId("b"), {{200, 0, 0}, Variance(0.1)});
  placement.Visit(std::vector{Join("door", {At("b", {}), At("a", {})})});
  EXPECT_EQ(placement.link_points().at(LinkPointId("door")).pose.x, 200.0);
}

TEST(PlacementTest, AYawsUncertaintyCountsByItsLever) {
  // The near map's yaw is worse, but the place lies at its origin; in the far one it is 50 m out.
  Placement placement;
  placement.SetPlace(MapId("near"), {{1, 0, 0}, Variance(0.02, 0.1)});
  placement.SetPlace(MapId("far"), {{2, 0, 0}, Variance(0.01, 0.001)});
  placement.Visit(std::vector{Join("door", {At("far", {50, 0, 0}, 0.0), At("near", {0, 0, 0}, 0.0)})});
  EXPECT_EQ(placement.link_points().at(LinkPointId("door")).pose.x, 1.0);
}

TEST(PlacementTest, WhatIsNotInUsePlacesNoMap) {
  for (const LinkPointUse use : {LinkPointUse::kSuspended, LinkPointUse::kSwitchedOff}) {
    Placement placement;
    placement.SetPlace(MapId("hall"), {});
    EXPECT_THAT(placement.Visit(std::vector{Join("door", {At("hall", {4, 0, 0}), At("lab", {})}, use)}), IsEmpty());
    EXPECT_THAT(placement.link_points(), SizeIs(1)) << "it has a place all the same";
    EXPECT_THAT(placement.maps(), IsEmpty());
  }
}

TEST(PlacementTest, IsVisitedOnce) {
  Placement placement;
  placement.SetPlace(MapId("hall"), {});
  placement.Visit(std::vector{Join("door", {At("hall", {4, 0, 0})})});
  placement.Visit(std::vector{Join("door", {At("hall", {9, 0, 0})})});
  EXPECT_EQ(placement.link_points().at(LinkPointId("door")).pose.x, 4.0);
}

TEST(PlacementTest, APlacedMapKeepsItsPlace) {
  Placement placement;
  placement.SetPlace(MapId("hall"), {});
  placement.SetPlace(MapId("lab"), {{7, 7, 0}, Variance(0.5)});
  EXPECT_THAT(placement.Visit(std::vector{Join("door", {At("hall", {4, 0, 0}), At("lab", {})})}), IsEmpty());
  EXPECT_THAT(placement.maps(), IsEmpty()) << "moving it is up to the optimisation";
}

TEST(PlacementTest, GoesOnThroughMapsThatHungTogetherBefore) {
  const std::vector<LinkPoint> link_points = {
      Join("stairs", {At("lab", {5, 0, 0}), At("upstairs", {1, 1, 0})}),
      Join("candidate", {At("upstairs", {3, 1, 0})}),
      Join("elsewhere", {At("x", {}), At("y", {})}),
  };
  const LinkPoint door = Join("door", {At("hall", {10, 0, kQuarter}), At("lab", {0, 0, 0})});
  Placement placement;
  PlaceAll(placement, {{MapId("hall"), {}}}, link_points, door);
  EXPECT_THAT(placement.link_points(), SizeIs(3));
  EXPECT_THAT(placement.link_points().at(LinkPointId("stairs")).pose, PoseNear(Pose2{10, 5, kQuarter}, 1e-9, 1e-9));
  EXPECT_THAT(placement.link_points().at(LinkPointId("candidate")).pose, PoseNear(Pose2{10, 7, kQuarter}, 1e-9, 1e-9));
  ASSERT_THAT(placement.maps(), SizeIs(2));
  EXPECT_EQ(placement.maps()[0].first, MapId("lab"));
  EXPECT_EQ(placement.maps()[1].first, MapId("upstairs"));
}

// A random tree of rooms with exact doors: wherever the search starts, every room comes out where it is, each one
// less certain than the one before it.
TEST(PlacementTest, PlacesAllOfATreeWhereItIs) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> coordinate(-20.0, 20.0), angle(-3.0, 3.0);
    std::vector<Pose2> rooms = {{}};
    std::vector<LinkPoint> doors;
    std::vector<std::size_t> parent = {0};
    for (std::size_t i = 1; i < 12; ++i) {
      parent.push_back(random() % i);
      rooms.push_back({coordinate(random), coordinate(random), angle(random)});
      const Pose2 T_world_door{coordinate(random), coordinate(random), angle(random)};
      doors.push_back(Join("door-" + std::to_string(i),
                           {At("room-" + std::to_string(parent[i]), Between(rooms[parent[i]], T_world_door), 1e-4),
                            At("room-" + std::to_string(i), Between(rooms[i], T_world_door), 1e-4)}));
    }
    std::shuffle(doors.begin(), doors.end(), random);
    const auto first = std::find_if(doors.begin(), doors.end(),
                                    [](const LinkPoint& door) { return door.FindAnchor(MapId("room-0")) != nullptr; });
    Placement placement;
    PlaceAll(placement, {{MapId("room-0"), {}}}, doors, *first);
    std::map<MapId, PoseWithCovariance> placed(placement.maps().begin(), placement.maps().end());
    placed[MapId("room-0")] = {};
    for (std::size_t i = 1; i < rooms.size(); ++i) {
      const auto room = placed.find(MapId("room-" + std::to_string(i)));
      if (room == placed.end()) continue;  // joined to the root by another door than the first
      EXPECT_THAT(room->second.pose, PoseNear(rooms[i], 1e-9, 1e-9)) << "seed " << seed << ", room " << i;
      const PoseWithCovariance& before = placed.at(MapId("room-" + std::to_string(parent[i])));
      EXPECT_GT(room->second.covariance(2, 2), before.covariance(2, 2));
    }
    EXPECT_EQ(placed.size(), placement.maps().size() + 1) << "no map is placed twice";
  }
}

}  // namespace
}  // namespace enfilade::graph
