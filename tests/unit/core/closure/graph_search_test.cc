// SPDX-License-Identifier: Apache-2.0
#include "core/closure/graph_search.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/support/pose_matchers.h"
#include "tests/unit/core/closure/door_scenario.h"

namespace enfilade::closure {
namespace {

using ::enfilade::testing::PoseNear;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::ElementsAreArray;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::UnorderedElementsAre;
using Target = SearchGraph::Target;

// As the server has it: where the first map with a solved pose places each link point.
struct Indexed {
  explicit Indexed(const graph::GraphSnapshot& graph) {
    std::vector<graph::PointIndex::Point> points;
    for (const graph::LinkPoint* link_point : graph.ListLinkPoints()) {
      for (const graph::Anchor& anchor : link_point->anchors) {
        const PoseWithCovariance* T_world_map = graph.FindSolvedPose(anchor.map);
        if (T_world_map == nullptr) continue;
        points.push_back({graph.LinkPointSlot(link_point->id), T_world_map->pose * anchor.T_map_place.translation()});
        break;
      }
    }
    positions = positions.With(points);
    for (const graph::MapInGraph* map : graph.ListMaps()) {
      if (graph.FindSolvedPose(map->id) == nullptr) unplaced_maps.push_back(graph.MapSlot(map->id));
    }
  }

  graph::PointIndex positions;
  std::vector<int> unplaced_maps;
};

std::vector<std::string> PlacesOf(DoorKnowledge& knowledge) {
  GraphSearch search;
  EXPECT_OK(search.Run({Target::kPassedDoor}, knowledge));
  EXPECT_OK(search.Run({Target::kPlaces}, knowledge));
  std::vector<std::string> names;
  for (const ComparedPlace& place : *knowledge.places) {
    EXPECT_EQ(place.evidence.link_point, place.link_point->id);
    EXPECT_EQ(place.evidence.map, place.anchor->map);
    EXPECT_FALSE(place.images_compared || place.clouds_compared);
    names.push_back(place.link_point->id.value() + "@" + place.anchor->map.value());
  }
  return names;
}

std::vector<std::string> MapsOf(DoorKnowledge knowledge) {
  GraphSearch search;
  EXPECT_OK(search.Run({Target::kMaps}, knowledge));
  std::vector<std::string> names;
  for (const SearchedMap& searched : *knowledge.maps) names.push_back(searched.map->id.value());
  return names;
}

// With and without an index, which must not make a difference.
std::vector<std::string> FindPlaces(DoorScenario& scenario, DoorKnowledge* found = nullptr) {
  DoorKnowledge knowledge = scenario.Knowledge();
  const Indexed index(*knowledge.graph);
  DoorKnowledge indexed = knowledge;
  indexed.world_index = {.positions = &index.positions, .unplaced_maps = index.unplaced_maps};
  std::vector<std::string> names = PlacesOf(knowledge);
  EXPECT_EQ(PlacesOf(indexed), names);
  if (found != nullptr) *found = std::move(knowledge);
  return names;
}

std::vector<std::string> FindMaps(DoorScenario& scenario) {
  const DoorKnowledge knowledge = scenario.Knowledge();
  const Indexed index(*knowledge.graph);
  DoorKnowledge indexed = knowledge;
  indexed.world_index = {.positions = &index.positions, .unplaced_maps = index.unplaced_maps};
  std::vector<std::string> names = MapsOf(knowledge);
  EXPECT_EQ(MapsOf(indexed), names);
  return names;
}

TEST(GraphSearch, PredictsTheRobotInTheMapOfEachPlace) {
  DoorScenario scenario;
  DoorKnowledge found;
  EXPECT_THAT(FindPlaces(scenario, &found), ElementsAre("side@room"));
  const ComparedPlace& side = found.places->front();
  ASSERT_TRUE(side.evidence.predicted.has_value());
  EXPECT_THAT(side.evidence.predicted->pose, PoseNear(Pose2{2, 0, 0}, 1e-9, 1e-9));
  EXPECT_GT(side.evidence.predicted->covariance(0, 0), 3e-4) << "the robot's, and both anchors'";
  EXPECT_NEAR(*side.evidence.distance, 8.0, 1e-9) << "from the door, not from the robot";
}

TEST(GraphSearch, PlacesAreThoseOfOtherMapsOnTheEnteredLevel) {
  DoorScenario scenario;
  scenario.Add("in-room", {{"room", {3, 0, 0}}});
  scenario.Add("upstairs", {{"attic", {0, 0, 0}}});
  scenario.Add("own", {{"here", {10, 3, 0}}});
  scenario.Add("suspended", {{"room", {3, 0, 0}}}).use = graph::LinkPointUse::kSuspended;
  scenario.Add("switched-off", {{"room", {4, 0, 0}}}).use = graph::LinkPointUse::kSwitchedOff;
  scenario.Add("refused", {{"room", {3, 0, 0}}});
  scenario.Add("lift", {{"room", {5, 0, 0}}, {"attic", {5, 0, 0}}});
  scenario.knowledge().redundant = {LinkPointId("refused"), LinkPointId("lift")};
  EXPECT_THAT(FindPlaces(scenario), ElementsAre("in-room@room", "switched-off@room", "lift@room", "side@room"))
      << "only candidates are refused";
  scenario.knowledge().report.entered_level = 1;
  EXPECT_THAT(FindPlaces(scenario), UnorderedElementsAre("upstairs@attic", "lift@attic"));
}

TEST(GraphSearch, PlacesLieWithinTheSearchRadius) {
  DoorScenario scenario;
  scenario.Add("near", {{"room", {19, 0, 0}}});
  scenario.Add("far", {{"room", {21, 0, 0}}});
  EXPECT_THAT(FindPlaces(scenario), ElementsAre("side@room", "near@room"));
  scenario.knowledge().options.search_base = 30.0;
  EXPECT_THAT(FindPlaces(scenario), ElementsAre("side@room", "near@room", "far@room", "north@room", "north@hall"));
}

TEST(GraphSearch, TheRadiusGrowsWithTheDoorsUncertainty) {
  DoorScenario scenario;
  scenario.Add("far", {{"room", {24, 0, 0}}});
  EXPECT_THAT(FindPlaces(scenario), Not(Contains("far@room")));
  scenario.knowledge().T_map_door->covariance(0, 0) = 1.0;  // R = 20 m + 2 * 2.45 m
  EXPECT_THAT(FindPlaces(scenario), Contains("far@room"));
}

TEST(GraphSearch, PlacesOfMapsWithoutAWayThereComeLastAndAreNotLimitedByDistance) {
  DoorScenario scenario;
  scenario.AddMap("island", 0);
  scenario.Add("on-island", {{"island", {5000, 0, 0}}});
  DoorKnowledge found;
  EXPECT_THAT(FindPlaces(scenario, &found), ElementsAre("side@room", "on-island@island"));
  EXPECT_FALSE(found.places->back().evidence.predicted.has_value());
  EXPECT_FALSE(found.places->back().evidence.distance.has_value());
  scenario.knowledge().options.max_compared = 1;
  EXPECT_THAT(FindPlaces(scenario), ElementsAre("side@room"));
  scenario.knowledge().options.max_compared = 0;
  EXPECT_THAT(FindPlaces(scenario), IsEmpty());
}

TEST(GraphSearch, MapsAreThoseThatThePredictionReaches) {
  DoorScenario scenario;
  scenario.AddMap("island", 0);
  scenario.Add("on-island", {{"island", {0, 0, 0}}});
  scenario.Add("stairs", {{"here", {11, -5, 0}}, {"attic", {0, 0, 0}}});
  EXPECT_THAT(FindMaps(scenario), ElementsAre("room")) << "the hall's link point is 30 m away, the island has no way";
  scenario.knowledge().options.search_base = 31.0;
  EXPECT_THAT(FindMaps(scenario), ElementsAre("hall", "room"));
  scenario.knowledge().options.max_searched = 1;
  EXPECT_THAT(FindMaps(scenario), ElementsAre("room")) << "the nearest";
  scenario.knowledge().report.entered_level = 1;
  EXPECT_THAT(FindMaps(scenario), ElementsAre("attic"));
}

// A row of rooms to the north, 4 m each, whose link points the door may all be near to.
TEST(GraphSearch, OfManyThatMayBeNearTheNearestAreFound) {
  DoorScenario scenario;
  constexpr int kRooms = 500;
  std::vector<std::string> rooms;
  std::string before = "here";
  for (int i = 0; i < kRooms; ++i) {
    const std::string room = fmt::format("row{:03}", i);
    scenario.AddMap(room, 0);
    const std::string door = fmt::format("between{:03}", i);
    scenario.Add(door, {{before, {10, before == "here" ? 2.0 : 4.0, 0}}, {room, {10, 0, 0}}});
    PoseWithCovariance T_world_room = Sure({0, 2.0 + 4.0 * i, 0});
    T_world_room.covariance(1, 1) = 1e-4 * (2 * i + 2);
    scenario.Solve(room, T_world_room);
    before = room;
    rooms.push_back(room);
  }
  scenario.knowledge().T_map_door->covariance(1, 1) = 1e6;
  scenario.knowledge().T_map_robot->covariance(1, 1) = 1e6;
  DoorKnowledge found;
  FindPlaces(scenario, &found);
  ASSERT_EQ(found.places->size(), 40U);
  double last = 0.0;
  for (const ComparedPlace& place : *found.places) {
    EXPECT_GE(*place.evidence.distance, last);
    last = *place.evidence.distance;
  }
  // Each link point is in two rooms: the nearest 40 places are those of 20 link points, 4 m apart.
  EXPECT_LE(last, 81.0);
  rooms.resize(38);  // and the two of the scenario
  rooms.insert(rooms.begin(), {"hall", "room"});
  EXPECT_THAT(FindMaps(scenario), ElementsAreArray(rooms));
}

// Rooms on a grid, a door between each and the next; some not solved, some link points suspended, switched off or seen
// from one side only.
TEST(GraphSearch, AnIndexMakesNoDifference) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const auto chance = [&](double share) { return std::uniform_real_distribution<double>()(random) < share; };
    DoorScenario scenario;
    constexpr int kSide = 30;
    for (int i = 0; i < kSide * kSide; ++i) {
      const std::string room = fmt::format("grid{:03}", i);
      scenario.AddMap(room, chance(0.3) ? 1 : 0);
      const double x = 5.0 * (i % kSide);
      const double y = 5.0 * std::floor(i / kSide);
      if (chance(0.97)) scenario.Solve(room, Sure({x, y, 0.1 * (i % 7)}));
      const auto add = [&](const std::string& id, const std::vector<std::pair<std::string, Pose2>>& anchors) {
        const double kind = std::uniform_real_distribution<double>()(random);
        if (kind < 0.05)
          scenario.Add(id, anchors).use = graph::LinkPointUse::kSuspended;
        else if (kind < 0.9)
          scenario.Add(id, anchors);
        else
          scenario.Add(id, {anchors.back()});
      };
      if (i > 0) {
        // Where the two rooms' poses agree.
        const Pose2 in_world{x, y + 2.0, 0.0};
        const int before = i - 1;
        const Pose2 T_world_before{5.0 * (before % kSide), 5.0 * std::floor(before / kSide), 0.1 * (before % 7)};
        const Pose2 T_world_room{x, y, 0.1 * (i % 7)};
        add(fmt::format("door{:03}", i), {{fmt::format("grid{:03}", before), Inverse(T_world_before) * in_world},
                                          {room, Inverse(T_world_room) * in_world}});
      } else {
        scenario.Add("entry", {{"here", {0, 2, 0}}, {room, {0, 2, 0}}});
      }
    }
    scenario.knowledge().T_map_door = Sure({70, 80, 0});
    scenario.knowledge().T_map_robot = Sure({72, 80, 0});
    scenario.knowledge().T_map_door->covariance(0, 0) = chance(0.5) ? 1e6 : 1.0;
    scenario.knowledge().T_map_robot->covariance(0, 0) = scenario.knowledge().T_map_door->covariance(0, 0);
    EXPECT_FALSE(FindPlaces(scenario).empty());
    FindMaps(scenario);
  }
}

TEST(GraphSearch, APassedDoorHasItsLinkPointsAndSightingsApart) {
  DoorScenario scenario;
  scenario.Add("door", {{"here", {10, 0, 0}}, {"room", {0, 0, 0}}});
  scenario.Add("twin", {{"here", {10.4, 0, 0}}, {"room", {0.4, 0, 0}}});
  scenario.Add("sighting", {{"here", {8.3, 0, 0}}});
  scenario.Add("other-sighting", {{"here", {8.3, 6, 0}}});
  const DoorKnowledge knowledge = scenario.Knowledge();
  const PassedDoor passed = FindPassedDoor(knowledge);
  ASSERT_EQ(passed.link_points.size(), 2U);
  EXPECT_EQ(passed.link_points[0].known.link_point->id, LinkPointId("door")) << "the likeliest first";
  EXPECT_EQ(passed.link_points[1].known.link_point->id, LinkPointId("twin"));
  EXPECT_THAT(passed.link_points[0].place.evidence.predicted->pose, PoseNear(Pose2{2, 0, 0}, 1e-9, 1e-9));
  EXPECT_THAT(passed.sightings, ElementsAre(LinkPointId("sighting")));
}

TEST(GraphSearch, OfTheDoorsOfALiftThatOfTheEnteredLevelIsPassed) {
  DoorScenario scenario;
  const auto passed = [&] {
    std::vector<std::string> ids;
    for (const PassedLinkPoint& one : FindPassedDoor(scenario.Knowledge()).link_points) {
      ids.push_back(one.known.link_point->id.value());
    }
    return ids;
  };
  scenario.Add("upper", {{"here", {10, 0, 0}}, {"attic", {0, 0, 0}}});
  EXPECT_THAT(passed(), ElementsAre("upper")) << "into a cabin that is a map of another level";
  scenario.Add("lower", {{"here", {10.4, 0, 0}}, {"room", {0, 0, 0}}});
  EXPECT_THAT(passed(), ElementsAre("lower"));
  scenario.knowledge().report.entered_level = 0;
  EXPECT_THAT(passed(), ElementsAre("lower"));
  scenario.knowledge().report.entered_level = 1;
  EXPECT_THAT(passed(), ElementsAre("upper"));
  scenario.knowledge().report.entered_level = 7;
  EXPECT_THAT(passed(), IsEmpty());
}

TEST(GraphSearch, NeedsTheSessionsMapInTheGraph) {
  DoorScenario scenario;
  scenario.knowledge().map->id = MapId("deleted");
  DoorKnowledge knowledge = scenario.Knowledge();
  GraphSearch search;
  EXPECT_OK(search.Run({Target::kPassedDoor}, knowledge));
  EXPECT_TRUE(absl::IsNotFound(search.Run({Target::kPlaces}, knowledge)));
}

}  // namespace
}  // namespace enfilade::closure
