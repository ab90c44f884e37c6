// SPDX-License-Identifier: Apache-2.0
#include "core/closure/decide.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <functional>

#include "core/graph/paths/pose_chain.h"
#include "tests/support/pose_matchers.h"
#include "tests/unit/core/closure/door_scenario.h"

namespace enfilade::closure {
namespace {

using ::enfilade::testing::PoseNear;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;
using Kind = sensor::DoorReport::Kind;

constexpr Pose2 kRobotInRoom{2, 0, 0};

// --- Reports that cannot be judged.

TEST(DecideUnjudged, SaysWhyAndStartsAMapAfterAPassageOnly) {
  struct Case {
    const char* reason;
    std::function<void(DoorKnowledge&)> change;
  };
  const std::vector<Case> cases = {
      {"the session was only recorded", [](DoorKnowledge& k) { k.map.reset(); }},
      {"mapping failed: out of memory", [](DoorKnowledge& k) { k.mapping_error = "out of memory"; }},
      {"nothing was mapped when the robot was at the door", [](DoorKnowledge& k) { k.T_map_door.reset(); }},
      {"nothing was mapped when the robot was at the door", [](DoorKnowledge& k) { k.T_map_robot.reset(); }},
  };
  for (const Case& one : cases) {
    for (const Kind kind : {Kind::kCandidate, Kind::kPassage}) {
      DoorScenario scenario;
      scenario.knowledge().report.kind = kind;
      one.change(scenario.knowledge());
      const DoorRun run = scenario.Run();
      EXPECT_THAT(run.steps, IsEmpty()) << one.reason << ": nothing needs to be found out";
      const auto action = ActionOf<LeaveUnjudged>(run.judgement);
      EXPECT_THAT(run.judgement.reason, HasSubstr(one.reason));
      EXPECT_EQ(action.map.has_value(), kind == Kind::kPassage) << one.reason;
      if (action.map) {
        EXPECT_EQ(action.map->id, MapId("new-map"));
      }
    }
  }
}

TEST(DecideUnjudged, OdometryJoinsAPassageWhoseDoorWasNotMapped) {
  const std::vector<std::pair<const char*, std::function<void(DoorKnowledge&)>>> cases = {
      {"mapping failed: out of memory", [](DoorKnowledge& k) { k.mapping_error = "out of memory"; }},
      {"nothing was mapped when the robot was at the door", [](DoorKnowledge& k) { k.T_map_door.reset(); }},
      {"nothing was mapped when the robot was at the door", [](DoorKnowledge& k) { k.T_map_robot.reset(); }},
  };
  for (const auto& [reason, change] : cases) {
    DoorScenario scenario;
    change(scenario.knowledge());
    const Eigen::Matrix3d wide = Eigen::Matrix3d::Identity();
    scenario.knowledge().by_odometry = {{{9, 1, 0.2}, wide}, {{10, 1, 0.2}, wide}, {{1, 0.5, 0}, wide}};
    const DoorRun run = scenario.Run();
    EXPECT_THAT(run.steps, IsEmpty());
    const auto action = ActionOf<StartMap>(run.judgement);
    EXPECT_THAT(run.judgement.reason, HasSubstr(reason));
    ASSERT_THAT(action.link_point.anchors, SizeIs(2));
    EXPECT_EQ(action.link_point.anchors[0].T_map_place, (Pose2{9, 1, 0.2}));
    EXPECT_EQ(action.link_point.anchors[0].covariance, wide);
    ASSERT_TRUE(action.entered.T_map_robot);
    EXPECT_EQ(action.entered.T_map_robot->pose, (Pose2{1, 0.5, 0}));
  }
}

// --- Candidates.

TEST(DecideCandidate, MakesOneWhereNoPlaceIsKnown) {
  DoorScenario scenario;
  scenario.knowledge().report.kind = Kind::kCandidate;
  scenario.knowledge().report.place = graph::LinkPointKind::kLift;
  scenario.knowledge().has_views = true;
  const DoorRun run = scenario.Run();
  EXPECT_THAT(run.steps, IsEmpty());
  const graph::LinkPoint candidate = ActionOf<MakeCandidate>(run.judgement).candidate;
  EXPECT_EQ(candidate.id, LinkPointId("new-point"));
  EXPECT_EQ(candidate.kind, graph::LinkPointKind::kLift);
  ASSERT_THAT(candidate.anchors, SizeIs(1));
  EXPECT_EQ(candidate.anchors[0].map, MapId("here"));
  EXPECT_EQ(candidate.anchors[0].T_map_place, (Pose2{10, 0, 0}));
  EXPECT_EQ(candidate.anchors[0].covariance, SmallCovariance());
  EXPECT_EQ(run.judgement.reason, "no place is known there");
}

TEST(DecideCandidate, SaysIfThereIsNoEvidenceToKeep) {
  DoorScenario scenario;
  scenario.knowledge().report.kind = Kind::kCandidate;
  EXPECT_THAT(scenario.Run().judgement.reason, HasSubstr("neither images nor clouds were recorded"));
}

TEST(DecideCandidate, KnowsTheNearestPlaceAhead) {
  DoorScenario scenario;
  scenario.knowledge().report.kind = Kind::kCandidate;
  scenario.Add("far", {{"here", {11.2, 0, 0}}});
  scenario.Add("near", {{"here", {10.4, 0.3, 0.2}}});
  scenario.Add("turned-away", {{"here", {10, 0, M_PI}}});
  scenario.Add("other-map", {{"room", {10, 0, 0}}});
  scenario.Add("suspended", {{"here", {10, 0, 0}}}).use = graph::LinkPointUse::kSuspended;
  const DoorRun run = scenario.Run();
  EXPECT_EQ(ActionOf<KeepKnownCandidate>(run.judgement).link_point, LinkPointId("near"));
  EXPECT_THAT(run.judgement.reason, HasSubstr("a door seen before is 0.4 m ahead"));
}

TEST(DecideCandidate, ALinkPointAheadIsKnownFromFartherAwayThanASighting) {
  for (const double distance : {2.5, 3.3}) {
    DoorScenario point;
    point.knowledge().report.kind = Kind::kCandidate;
    point.Add("door", {{"here", {10 + distance, 0, M_PI}}, {"room", {distance, 0, 0}}});
    EXPECT_EQ(ActionOf<KeepKnownCandidate>(point.Run().judgement).link_point, LinkPointId("door")) << distance;
    DoorScenario sighting;
    sighting.knowledge().report.kind = Kind::kCandidate;
    sighting.Add("seen", {{"here", {10 + distance, 0, 0}}});
    EXPECT_EQ(ActionOf<MakeCandidate>(sighting.Run().judgement).candidate.id, LinkPointId("new-point")) << distance;
  }
}

// --- A link point of the session's own map.

TEST(DecidePassed, RecognisesItByPoseAndImagesWithoutRegisteringClouds) {
  DoorScenario scenario;
  scenario.Add("door", {{"here", {10.1, 0.1, M_PI}}, {"room", {0, 0, M_PI}}});
  scenario.Agree("door", "room", kRobotInRoom);
  const DoorRun run = scenario.Run();
  EXPECT_THAT(run.steps, ElementsAre("graph:door", "images:door"));
  const auto action = ActionOf<RecogniseLinkPoint>(run.judgement);
  EXPECT_EQ(action.link_point, LinkPointId("door"));
  EXPECT_EQ(action.entered.map, MapId("room"));
  // By the link point's anchors, not by registration: within one map the pose is strong evidence.
  EXPECT_THAT(action.entered.T_map_robot->pose, PoseNear(Pose2{1.9, -0.1, 0}, 1e-9, 1e-9));
  ASSERT_THAT(run.judgement.comparisons, SizeIs(1));
  EXPECT_TRUE(run.judgement.comparisons[0].accepted);
  EXPECT_TRUE(run.judgement.comparisons[0].chi2.has_value());
  EXPECT_EQ(run.judgement.comparisons[0].distance, run.knowledge.passed->link_points[0].known.distance);
  EXPECT_THAT(run.judgement.reason, AllOf(HasSubstr("in the same map"), HasSubstr("60 matches")));
  EXPECT_THAT(run.judgement.used_up, IsEmpty());
}

TEST(DecidePassed, NeedsBothImagesAndCloudsAgainstItToBeContradicted) {
  struct Case {
    const char* what;
    EvidenceBook::Views views;
    bool recognised;
    bool clouds_asked;
  };
  const ImageComparison agree{60, true};
  const ImageComparison disagree{2, false};
  const CloudComparison other_place{1.0, 0.2, false, {}};
  const CloudComparison changed{1.0, 0.45, false, {}};  // furniture was moved
  const CloudComparison same{0.05, 0.9, true, Sure(kRobotInRoom)};
  const std::vector<Case> cases = {
      {"nothing to compare", {}, true, true},
      {"images agree", {.images = agree, .clouds = other_place}, true, false},
      {"images disagree, no clouds", {.images = disagree, .clouds = {}}, true, true},
      {"images disagree, clouds agree", {.images = disagree, .clouds = same}, true, true},
      {"images disagree, clouds a little alike", {.images = disagree, .clouds = changed}, true, true},
      {"no images, clouds disagree", {.images = {}, .clouds = other_place}, true, true},
      {"both disagree", {.images = disagree, .clouds = other_place}, false, true},
  };
  for (const Case& one : cases) {
    DoorScenario scenario;
    scenario.Add("door", {{"here", {10, 0, 0}}, {"room", {0, 0, 0}}});
    scenario.book().views[{"door", "room"}] = one.views;
    const DoorRun run = scenario.Run();
    EXPECT_EQ(std::holds_alternative<RecogniseLinkPoint>(run.judgement.action), one.recognised) << one.what;
    EXPECT_EQ(std::count(run.steps.begin(), run.steps.end(), "clouds:door") == 1, one.clouds_asked) << one.what;
    ASSERT_FALSE(run.judgement.comparisons.empty()) << one.what;
    EXPECT_EQ(run.judgement.comparisons[0].accepted, one.recognised) << one.what;
  }
}

TEST(DecidePassed, AContradictedOneIsNotComparedAgainAndTheNextOneIsTried) {
  DoorScenario scenario;
  scenario.Add("nearer", {{"here", {10, 0, 0}}, {"room", {0, 0, 0}}});
  scenario.Add("next", {{"here", {10.3, 0, 0}}, {"room", {0.3, 0, 0}}});
  scenario.ShowNothing("nearer", "room");
  DoorRun run = scenario.Run();
  EXPECT_THAT(run.steps, ElementsAre("graph:door", "images:nearer", "clouds:nearer", "images:next", "clouds:next"));
  EXPECT_EQ(ActionOf<RecogniseLinkPoint>(run.judgement).link_point, LinkPointId("next"));
  EXPECT_THAT(run.judgement.comparisons, SizeIs(2));

  scenario.ShowNothing("next", "room");
  run = scenario.Run();
  EXPECT_THAT(run.steps, Contains("graph:places"));
  for (const ComparedPlace& place : *run.knowledge.places) {
    EXPECT_THAT(place.link_point->id.value(), Not(::testing::AnyOf("nearer", "next")));
  }
  EXPECT_THAT(run.judgement.comparisons[0].reason, HasSubstr("what the robot sees contradicts it"));
}

TEST(DecidePassed, TheNextDoorIsNotThisOne) {
  for (const double beside : {0.9, 1.5, -1.2}) {
    DoorScenario scenario;
    scenario.Add("next-door", {{"here", {10, beside, 0}}, {"room", {0, beside, 0}}});
    const DoorRun run = scenario.Run();
    EXPECT_THAT(run.knowledge.passed->link_points, IsEmpty()) << beside;
    EXPECT_TRUE(std::holds_alternative<StartMap>(run.judgement.action)) << beside;
  }
}

// --- Places of other maps, by images and clouds.

TEST(DecidePlaces, PromotesACandidateOfTheEnteredMap) {
  DoorScenario scenario;
  scenario.AddRoomCandidate("seen-from-room");
  scenario.Add("seen-from-here", {{"here", {8.3, 0, 0}}});
  scenario.Agree("seen-from-room", "room", kRobotInRoom);
  scenario.knowledge().report.place = graph::LinkPointKind::kRamp;
  const DoorRun run = scenario.Run();
  EXPECT_THAT(run.steps, ElementsAre("graph:door", "graph:places", "images:seen-from-room,side",
                                     "clouds:seen-from-room", "clouds:side"));
  const auto action = ActionOf<PromoteCandidate>(run.judgement);
  EXPECT_EQ(action.link_point, LinkPointId("seen-from-room"));
  EXPECT_EQ(action.kind, graph::LinkPointKind::kRamp);
  EXPECT_EQ(action.entered.map, MapId("room"));
  EXPECT_THAT(action.entered.T_map_robot->pose, PoseNear(kRobotInRoom, 1e-9, 1e-9));
  // The link point is the door itself, in both maps; not where the candidate was seen from.
  ASSERT_THAT(action.anchors, SizeIs(2));
  EXPECT_EQ(action.anchors[0].map, MapId("room"));
  EXPECT_THAT(action.anchors[0].T_map_place, PoseNear(Pose2{0, 0, 0}, 1e-9, 1e-9));
  EXPECT_EQ(action.anchors[1].map, MapId("here"));
  EXPECT_THAT(action.anchors[1].T_map_place, PoseNear(Pose2{10, 0, 0}, 1e-9, 1e-9));
  // The sighting from this side is the same door.
  EXPECT_THAT(run.judgement.used_up, ElementsAre(LinkPointId("seen-from-here")));
}

TEST(DecidePlaces, JoinsTheMapToALinkPointOfOtherMaps) {
  DoorScenario scenario;
  scenario.Add("crossing", {{"room", {0.1, 0, 0}}, {"hall", {40, 0, 0}}});
  scenario.Agree("crossing", "room", kRobotInRoom);
  const DoorRun run = scenario.Run();
  const auto action = ActionOf<JoinLinkPoint>(run.judgement);
  EXPECT_EQ(action.link_point, LinkPointId("crossing"));
  EXPECT_EQ(action.entered.map, MapId("room"));
  // The link point's place, seen from the session's map.
  EXPECT_EQ(action.anchor.map, MapId("here"));
  EXPECT_THAT(action.anchor.T_map_place, PoseNear(Pose2{10.1, 0, 0}, 1e-9, 1e-9));
  EXPECT_GT(action.anchor.covariance(0, 0), 1.9e-4) << "both poses' covariances";
  EXPECT_THAT(run.judgement.reason, HasSubstr("this map is joined to it, too"));
}

TEST(DecidePlaces, AnotherDoorOfARoomBecomesALinkPointBetweenTheMaps) {
  DoorScenario scenario;
  scenario.Agree("side", "room", kRobotInRoom);  // the room is recognised, at a door 8 m away
  const DoorRun run = scenario.Run();
  const auto action = ActionOf<LinkKnownMaps>(run.judgement);
  EXPECT_EQ(action.link_point.id, LinkPointId("new-point"));
  EXPECT_EQ(action.link_point.direction, MapId("room"));
  ASSERT_THAT(action.link_point.anchors, SizeIs(2));
  EXPECT_EQ(action.link_point.anchors[0].map, MapId("here"));
  EXPECT_THAT(action.link_point.anchors[0].T_map_place, PoseNear(Pose2{10, 0, 0}, 1e-9, 1e-9));
  EXPECT_EQ(action.link_point.anchors[1].map, MapId("room"));
  EXPECT_THAT(action.link_point.anchors[1].T_map_place, PoseNear(Pose2{0, 0, 0}, 1e-9, 1e-9));
  // The chain across the new link point puts the robot where registration found it.
  const PoseWithCovariance T_room_here =
      graph::TransformAcross(action.link_point.anchors[1], action.link_point.anchors[0]);
  EXPECT_THAT(T_room_here.pose * Pose2({12, 0, 0}), PoseNear(kRobotInRoom, 1e-9, 1e-9));
}

TEST(DecidePlaces, ADoorThatJoinsTheMapsAlreadyIsNotMadeTwice) {
  DoorScenario scenario;
  // Too far off for the gate in `here`, by yaw, but the same place for the database.
  scenario.Add("twin", {{"here", {10.1, 0, 1.2}}, {"room", {0.1, 0, 1.2}}});
  scenario.AddRoomCandidate("seen-from-room");
  scenario.Agree("seen-from-room", "room", kRobotInRoom);
  const DoorRun run = scenario.Run();
  EXPECT_EQ(ActionOf<RecogniseLinkPoint>(run.judgement).link_point, LinkPointId("twin"));
  EXPECT_THAT(run.judgement.reason, HasSubstr("a link point joins the maps at that place already"));
  EXPECT_THAT(run.judgement.used_up, ElementsAre(LinkPointId("seen-from-room"))) << "it was a sighting of that door";
}

TEST(DecidePlaces, ACandidateThatTheDatabaseRefusedIsLeftOut) {
  DoorScenario scenario;
  scenario.AddRoomCandidate("refused");
  scenario.Agree("refused", "room", kRobotInRoom);
  scenario.knowledge().redundant = {LinkPointId("refused")};
  const DoorRun run = scenario.Run();
  EXPECT_THAT(run.steps, Not(Contains(HasSubstr("refused"))));
  EXPECT_TRUE(std::holds_alternative<StartMap>(run.judgement.action));
}

TEST(DecidePlaces, ALinkPointThatTheDatabaseRefusedToJoinGetsANeighbour) {
  DoorScenario scenario;
  scenario.Add("crossing", {{"room", {0.1, 0, 0}}, {"hall", {40, 0, 0}}});
  scenario.Agree("crossing", "room", kRobotInRoom);
  scenario.knowledge().redundant = {LinkPointId("crossing")};
  const auto action = ActionOf<LinkKnownMaps>(scenario.Run().judgement);
  EXPECT_EQ(action.link_point.direction, MapId("room"));
  ASSERT_THAT(action.link_point.anchors, SizeIs(2));
  EXPECT_EQ(action.link_point.anchors[0].map, MapId("here"));
}

TEST(DecidePlaces, OfTwoPlacesThatHaveTheRobotHereTheDoorItPassedIsTaken) {
  DoorScenario scenario;
  scenario.AddRoomCandidate("this-door");
  scenario.Agree("side", "room", kRobotInRoom, 90);  // the better images, but another door
  scenario.Agree("this-door", "room", kRobotInRoom, 50);
  EXPECT_EQ(ActionOf<PromoteCandidate>(scenario.Run().judgement).link_point, LinkPointId("this-door"));
}

TEST(DecidePlaces, StartsAMapWhereNothingIsKnown) {
  DoorScenario scenario;
  scenario.Add("seen-from-here", {{"here", {8.3, 0, 0}}});
  scenario.knowledge().report.entered_environment = Environment::kOutdoor;
  scenario.knowledge().report.place = graph::LinkPointKind::kDoor;
  scenario.knowledge().options.outdoor_profile = "yard";
  const DoorRun run = scenario.Run();
  const auto action = ActionOf<StartMap>(run.judgement);
  EXPECT_EQ(action.map.id, MapId("new-map"));
  EXPECT_EQ(action.map.environment, Environment::kOutdoor);
  EXPECT_EQ(action.map.slam_profile, "yard");
  EXPECT_EQ(action.link_point.id, LinkPointId("new-point"));
  EXPECT_EQ(action.link_point.direction, MapId("new-map"));
  ASSERT_THAT(action.link_point.anchors, SizeIs(2));
  EXPECT_EQ(action.link_point.anchors[0].T_map_place, (Pose2{10, 0, 0}));
  EXPECT_EQ(action.link_point.anchors[1].T_map_place, (Pose2{0, 0, 0})) << "the door is the new map's origin";
  EXPECT_EQ(action.entered.map, MapId("new-map"));
  EXPECT_THAT(action.entered.T_map_robot->pose, PoseNear(Pose2{2, 0, 0}, 1e-9, 1e-9));
  EXPECT_THAT(run.judgement.used_up, ElementsAre(LinkPointId("seen-from-here")));
  EXPECT_THAT(run.judgement.reason, HasSubstr("none of 1 known places was accepted"));
}

TEST(DecidePlaces, AnEmptySiteNeedsNoEvidence) {
  DoorScenario scenario;
  scenario.knowledge().report.entered_level = 5;  // where there is no map
  const DoorRun run = scenario.Run();
  EXPECT_THAT(run.steps, ElementsAre("graph:door", "graph:places", "graph:maps"));
  EXPECT_EQ(ActionOf<StartMap>(run.judgement).map.level, 5);
  EXPECT_EQ(run.judgement.reason, "no known place within the search radius");
}

// The images of two rooms look the same, and the graph knows the way to neither.
TEST(DecidePlaces, TakesNeitherOfTwoLookAlikesAndAsksNoScans) {
  DoorScenario scenario;
  scenario.AddMap("twin-a", 0);
  scenario.AddMap("twin-b", 0);
  scenario.Add("a", {{"twin-a", {1.7, 0, M_PI}}});
  scenario.Add("b", {{"twin-b", {1.7, 0, M_PI}}});
  scenario.Agree("a", "twin-a", kRobotInRoom);
  scenario.Agree("b", "twin-b", kRobotInRoom);
  scenario.LocateIn("room", kRobotInRoom);
  DoorRun run = scenario.Run();
  EXPECT_TRUE(std::holds_alternative<StartMap>(run.judgement.action));
  EXPECT_THAT(run.judgement.reason, HasSubstr("look alike"));
  EXPECT_THAT(run.steps, Not(Contains("graph:maps"))) << "scans cannot tell them apart either";
  ASSERT_GE(run.judgement.comparisons.size(), 2U);
  EXPECT_TRUE(run.judgement.comparisons[0].accepted && run.judgement.comparisons[1].accepted);

  scenario.Agree("a", "twin-a", kRobotInRoom, 110);  // clearly better
  run = scenario.Run();
  EXPECT_EQ(ActionOf<PromoteCandidate>(run.judgement).link_point, LinkPointId("a"));
}

TEST(DecidePlaces, TheGraphRefusesAPoseOutsideTheGate) {
  for (const auto& [off, accepted] :
       std::vector<std::pair<double, bool>>{{0.0, true}, {0.3, true}, {1.0, false}, {-0.3, true}, {-1.0, false}}) {
    DoorScenario scenario;
    scenario.AddRoomCandidate("seen-from-room");
    scenario.Agree("seen-from-room", "room", {2 + off, 0, 0});
    const DoorRun run = scenario.Run();
    EXPECT_EQ(std::holds_alternative<PromoteCandidate>(run.judgement.action), accepted)
        << off << ": " << run.judgement.comparisons[0].reason;
  }
}

}  // namespace
}  // namespace enfilade::closure
