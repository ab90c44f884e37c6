// SPDX-License-Identifier: Apache-2.0
#include "core/closure/decide.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <functional>
#include <random>

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

TEST(DecidePassed, ALiftLeadsToTheEnteredLevel) {
  DoorScenario scenario;
  scenario.Add("lift", {{"attic", {5, 5, 0}}, {"here", {10, 0, 0}}, {"room", {0, 0, 0}}});
  EXPECT_EQ(ActionOf<RecogniseLinkPoint>(scenario.Run().judgement).entered.map, MapId("room"));
  scenario.knowledge().report.entered_level = 1;
  const auto up = ActionOf<RecogniseLinkPoint>(scenario.Run().judgement);
  EXPECT_EQ(up.entered.map, MapId("attic"));
  EXPECT_THAT(up.entered.T_map_robot->pose, PoseNear(Pose2{7, 5, 0}, 1e-9, 1e-9));
  // No anchor on that level: the first other one, rather than none.
  scenario.knowledge().report.entered_level = 7;
  EXPECT_EQ(ActionOf<RecogniseLinkPoint>(scenario.Run().judgement).entered.map, MapId("attic"));
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

// --- Which clouds are registered: registration is expensive.

TEST(DecideCost, RegistersTheCloudsOfTheBestImagesFirstAndOfAFewPlacesOnly) {
  DoorScenario scenario;
  scenario.knowledge().options.max_registered = 3;
  for (int i = 0; i < 6; ++i) {
    const std::string id = "place-" + std::to_string(i);
    scenario.Add(id, {{"room", {3.0 + i, 5, M_PI}}});
    // Images agree everywhere, the better the farther; clouds are of another place.
    scenario.book().views[{id, "room"}] = {.images = ImageComparison{20 + i, true},
                                           .clouds = CloudComparison{1.0, 0.45, false, {}}};
  }
  scenario.knowledge().points_behind_door.clear();
  const DoorRun run = scenario.Run();
  EXPECT_THAT(run.steps, ElementsAre("graph:door", "graph:places", HasSubstr("images:place-0,"), "clouds:place-5",
                                     "clouds:place-4", "clouds:place-3"));
  EXPECT_THAT(run.judgement.comparisons, SizeIs(7)) << "all places, compared or not";
}

TEST(DecideCost, AMissingCloudDoesNotCountAsRegistered) {
  DoorScenario scenario;
  scenario.knowledge().options.max_registered = 1;
  scenario.AddRoomCandidate("without-cloud");
  scenario.Add("with-cloud", {{"room", {1.7, 3, M_PI}}});
  scenario.book().views[{"without-cloud", "room"}].images = ImageComparison{90, true};
  scenario.Agree("with-cloud", "room", kRobotInRoom, 60);
  scenario.Agree("side", "room", kRobotInRoom, 40);
  EXPECT_THAT(scenario.Run().steps, ElementsAre("graph:door", "graph:places", HasSubstr("images:"),
                                                "clouds:without-cloud", "clouds:with-cloud"));
}

TEST(DecideCost, ImagesThatDisagreeSaveTheRegistrationUnlessThePlaceIsAtThisDoor) {
  DoorScenario scenario;
  scenario.Add("at-door", {{"room", {1.7, 0, M_PI}}});
  scenario.Add("elsewhere", {{"room", {1.7, 10, M_PI}}});
  scenario.AddMap("unlinked", 0);
  scenario.Add("nowhere", {{"unlinked", {0, 0, 0}}});
  for (const auto& [id, map] : std::vector<std::pair<const char*, const char*>>{
           {"at-door", "room"}, {"elsewhere", "room"}, {"nowhere", "unlinked"}, {"side", "room"}}) {
    scenario.book().views[{id, map}].images = ImageComparison{2, false};
  }
  scenario.knowledge().points_behind_door.clear();
  EXPECT_THAT(scenario.Run().steps,
              ElementsAre("graph:door", "graph:places", "images:at-door,side,elsewhere,nowhere", "clouds:at-door"));
}

TEST(DecideCost, ComparesTheNearestPlacesOnlyIfThereAreTooMany) {
  DoorScenario scenario;
  scenario.knowledge().options.max_compared = 2;
  for (int i = 9; i > 0; --i) scenario.Add("place-" + std::to_string(i), {{"room", {1.0 + i, 0, M_PI}}});
  const DoorRun run = scenario.Run();
  EXPECT_THAT(run.steps, Contains("images:place-1,place-2"));
}

// --- Scans.

TEST(DecideScans, LinkTheMapThatTheyFindTheRobotIn) {
  DoorScenario scenario;
  scenario.LocateIn("room", kRobotInRoom);
  const DoorRun run = scenario.Run();
  EXPECT_THAT(run.steps,
              ElementsAre("graph:door", "graph:places", "images:side", "clouds:side", "graph:maps", "scans:room"));
  const auto action = ActionOf<LinkKnownMaps>(run.judgement);
  EXPECT_EQ(action.entered.map, MapId("room"));
  EXPECT_THAT(action.entered.T_map_robot->pose, PoseNear(kRobotInRoom, 1e-9, 1e-9));
  EXPECT_THAT(run.judgement.reason, AllOf(HasSubstr("another door of a map that is known"),
                                          HasSubstr("the scans show where the robot is: 80 % on walls")));
  EXPECT_THAT(run.judgement.comparisons, SizeIs(1)) << "what was compared before is still reported";
}

TEST(DecideScans, AreNotMatchedIfThereIsNothingBehindTheDoor) {
  DoorScenario scenario;
  scenario.LocateIn("room", kRobotInRoom);
  scenario.knowledge().points_behind_door.clear();
  const DoorRun run = scenario.Run();
  EXPECT_THAT(run.steps, Not(Contains("graph:maps")));
  EXPECT_TRUE(std::holds_alternative<StartMap>(run.judgement.action));
}

TEST(DecideScans, TakeTheKnownPlaceAtTheDoor) {
  struct Case {
    const char* what;
    std::function<void(DoorScenario&)> add;
    std::size_t action;  // index of the action
  };
  const std::vector<Case> cases = {
      {"a candidate", [](DoorScenario& s) { s.AddRoomCandidate("place"); }, DoorAction(PromoteCandidate{}).index()},
      {"a link point of other maps",
       [](DoorScenario& s) {
         s.Add("place", {{"room", {0, 0, 0}}, {"hall", {40, 0, 0}}});
       },
       DoorAction(JoinLinkPoint{}).index()},
      {"both",
       [](DoorScenario& s) {
         s.AddRoomCandidate("a-candidate");
         s.Add("place", {{"room", {0, 0, 0}}, {"hall", {40, 0, 0}}});
       },
       DoorAction(JoinLinkPoint{}).index()},
      {"a suspended candidate",
       [](DoorScenario& s) { s.AddRoomCandidate("place").use = graph::LinkPointUse::kSuspended; },
       DoorAction(LinkKnownMaps{}).index()},
      {"a refused candidate",
       [](DoorScenario& s) {
         s.AddRoomCandidate("place");
         s.knowledge().redundant = {LinkPointId("place")};
       },
       DoorAction(LinkKnownMaps{}).index()},
      {"a candidate of another door",
       [](DoorScenario& s) {
         s.Add("place", {{"room", {1.7, 6, M_PI}}});
       },
       DoorAction(LinkKnownMaps{}).index()},
  };
  for (const Case& one : cases) {
    DoorScenario scenario;
    one.add(scenario);
    scenario.LocateIn("room", kRobotInRoom);
    const DoorRun run = scenario.Run();
    EXPECT_EQ(run.judgement.action.index(), one.action) << one.what << ": " << run.judgement.reason;
    EXPECT_EQ(ToVerdict(run.judgement).entered_map, MapId("room")) << one.what;
  }
}

TEST(DecideScans, AreContradictedByTheCloudOfTheVeryDoor) {
  struct Case {
    const char* what;
    EvidenceBook::Views views;
    bool contradicted;
  };
  const ImageComparison disagree{2, false};
  const std::vector<Case> cases = {
      {"no clouds", {}, false},
      {"images disagree, no clouds", {.images = disagree, .clouds = {}}, false},
      {"another place", {.images = {}, .clouds = CloudComparison{1.0, 0.2, false, {}}}, true},
      {"hardly alike", {.images = {}, .clouds = CloudComparison{1.0, 0.45, false, {}}}, false},
      {"hardly alike, images disagree", {.images = disagree, .clouds = CloudComparison{1.0, 0.45, false, {}}}, true},
      {"alike, the robot at the same pose",
       {.images = disagree, .clouds = CloudComparison{0.1, 0.7, true, Sure({2.1, 0, 0})}},
       false},
      {"alike, the robot elsewhere",
       {.images = disagree, .clouds = CloudComparison{0.1, 0.7, true, Sure({3.2, 0, 0})}},
       true},
  };
  for (const Case& one : cases) {
    DoorScenario scenario;
    scenario.AddRoomCandidate("at-door");
    scenario.book().views[{"at-door", "room"}] = one.views;
    scenario.LocateIn("room", kRobotInRoom);
    const DoorRun run = scenario.Run();
    EXPECT_EQ(std::holds_alternative<StartMap>(run.judgement.action), one.contradicted)
        << one.what << ": " << run.judgement.reason;
    EXPECT_EQ(run.judgement.reason.find("what was seen of the door contradicts it") != std::string::npos,
              one.contradicted)
        << one.what;
  }
}

TEST(DecideScans, TakeNoMapIfTwoWouldDo) {
  DoorScenario scenario;
  scenario.Add("in-hall", {{"hall", {2, -20, 0}}});  // brings the hall within the search radius
  scenario.LocateIn("room", kRobotInRoom);
  scenario.LocateIn("hall", {2, -30, 0});
  const DoorRun run = scenario.Run();
  EXPECT_TRUE(std::holds_alternative<StartMap>(run.judgement.action));
  EXPECT_THAT(run.judgement.reason, HasSubstr("its scans fit into 2 maps"));
}

TEST(DecideScans, WaitForMapsThatAreBeingMappedWithinPatience) {
  struct Case {
    bool recording;
    bool mapping;
    double waited;
    bool waits;
  };
  const std::vector<Case> cases = {
      {false, false, 0.0, false}, {true, false, 0.0, true},   {true, false, 19.0, true},  {true, false, 20.0, false},
      {false, true, 0.0, true},   {false, true, 20.0, true},  {false, true, 119.0, true}, {false, true, 120.0, false},
      {true, true, 60.0, true},   {true, true, 500.0, false},
  };
  for (const Case& one : cases) {
    DoorScenario scenario;
    scenario.book().scans["room"] = {
        .location = {.reason = "not enough"}, .recording = one.recording, .mapping = one.mapping};
    scenario.knowledge().waited = one.waited;
    const DoorRun run = scenario.Run();
    const auto* wait = std::get_if<WaitForMapping>(&run.judgement.action);
    EXPECT_EQ(wait != nullptr, one.waits) << one.recording << one.mapping << " " << one.waited;
    if (wait != nullptr) {
      EXPECT_THAT(wait->maps, ElementsAre("The room"));
    } else {
      EXPECT_THAT(run.judgement.reason, HasSubstr("by its scans not in \"The room\": not enough"));
    }
  }
}

// It may turn out that the other one fits, too.
TEST(DecideScans, WaitEvenIfAnotherMapFits) {
  DoorScenario scenario;
  scenario.Add("in-hall", {{"hall", {2, -20, 0}}});
  scenario.LocateIn("room", kRobotInRoom);
  scenario.book().scans["hall"].mapping = true;
  EXPECT_THAT(ActionOf<WaitForMapping>(scenario.Run().judgement).maps, ElementsAre("The hall"));
  scenario.book().scans["hall"].mapping = false;
  EXPECT_EQ(ActionOf<LinkKnownMaps>(scenario.Run().judgement).entered.map, MapId("room"));
}

TEST(DecideScans, AMapThatFitsIsNotWaitedFor) {
  DoorScenario scenario;
  scenario.LocateIn("room", kRobotInRoom);
  scenario.book().scans["room"].recording = true;
  EXPECT_EQ(ActionOf<LinkKnownMaps>(scenario.Run().judgement).entered.map, MapId("room"));
}

// --- Properties that hold for any knowledge.

// A scenario with random places and evidence around the passed door.
DoorScenario RandomScenario(std::mt19937& random) {
  DoorScenario scenario;
  const auto uniform = [&](double from, double to) { return std::uniform_real_distribution<>(from, to)(random); };
  const auto chance = [&](double share) { return uniform(0, 1) < share; };
  scenario.AddMap("unlinked", 0);
  const int places = static_cast<int>(uniform(1, 7));
  for (int i = 0; i < places; ++i) {
    const std::string id = "place-" + std::to_string(i);
    const std::string map = chance(0.7) ? "room" : (chance(0.5) ? "hall" : "unlinked");
    const double north = map == "hall" ? -30.0 : 0.0;
    if (chance(0.6)) {
      scenario.Add(id, {{map, {uniform(0, 4), north + uniform(-3, 3), M_PI + uniform(-0.5, 0.5)}}});
    } else {
      scenario.Add(id, {{map, {uniform(-1, 1), north + uniform(-2, 2), uniform(-0.5, 0.5)}},
                        {"attic", {uniform(-9, 9), uniform(-9, 9), 0}}});
    }
    EvidenceBook::Views views;
    if (chance(0.8)) {
      const int matches = static_cast<int>(uniform(0, 120));
      views.images = ImageComparison{matches, matches > 15};
    }
    if (chance(0.8)) {
      const double share = uniform(0.1, 1.0);
      views.clouds = CloudComparison{0.1, share, share > 0.5,
                                     Sure({2 + uniform(-0.5, 0.5), north + uniform(-0.5, 0.5), uniform(-0.1, 0.1)})};
    }
    scenario.book().views[{id, map}] = views;
  }
  for (const char* map : {"room", "hall"}) {
    if (chance(0.3)) scenario.LocateIn(map, {2, std::string(map) == "hall" ? -30.0 : 0.0, 0});
    scenario.book().scans[map].recording = chance(0.1);
  }
  return scenario;
}

std::string Text(const DoorJudgement& judgement) {
  const DoorVerdict verdict = ToVerdict(judgement);
  std::string text = fmt::format("{}/{} {} {} {}", judgement.action.index(), static_cast<int>(verdict.decision),
                                 verdict.link_point ? verdict.link_point->value() : "-",
                                 verdict.entered_map ? verdict.entered_map->value() : "-", judgement.reason);
  if (verdict.T_map_robot) {
    const Pose2& pose = verdict.T_map_robot->pose;
    text += fmt::format(" at {} {} {}", pose.x, pose.y, pose.yaw);
  }
  for (const DoorComparison& comparison : judgement.comparisons) {
    text += "\n  " + comparison.link_point.value() + ": " + comparison.reason;
  }
  for (const LinkPointId& id : judgement.used_up) text += "\n  used up: " + id.value();
  return text;
}

TEST(DecideProperties, TheOrderOfThePlacesDoesNotChangeTheJudgement) {
  std::mt19937 random(17);
  for (int seed = 0; seed < 300; ++seed) {
    DoorScenario scenario = RandomScenario(random);
    scenario.knowledge().options.max_registered = 100;
    const DoorRun run = scenario.Run();
    if (!run.knowledge.places) continue;
    DoorKnowledge shuffled = run.knowledge;
    std::shuffle(shuffled.places->begin(), shuffled.places->end(), random);
    EXPECT_EQ(Text(scenario.RunFrom(std::move(shuffled)).judgement), Text(run.judgement)) << seed;
  }
}

TEST(DecideProperties, APlaceFarAwayChangesNothing) {
  std::mt19937 random(18);
  for (int seed = 0; seed < 200; ++seed) {
    DoorScenario scenario = RandomScenario(random);
    const DoorRun run = scenario.Run();
    // In a map that the graph knows the way to, with the best evidence there is; and one on another level.
    scenario.AddMap("far-away", 0);
    scenario.Add("long-road", {{"hall", {400, 0, 0}}, {"far-away", {0, 0, 0}}});
    scenario.Add("far-place", {{"far-away", {60, 0, M_PI}}});
    scenario.Agree("far-place", "far-away", {60, 0, 0}, 400);
    scenario.LocateIn("far-away", {60, 0, 0});
    scenario.Add("upstairs", {{"attic", {1.7, 0, M_PI}}});
    scenario.Agree("upstairs", "attic", kRobotInRoom, 400);
    const DoorRun again = scenario.Run();
    EXPECT_EQ(Text(again.judgement), Text(run.judgement)) << seed;
    EXPECT_EQ(again.steps, run.steps) << seed;
  }
}

TEST(DecideProperties, EveryStepAsksForSomethingNewAndNothingTwice) {
  std::mt19937 random(19);
  for (int seed = 0; seed < 300; ++seed) {
    std::vector<std::string> steps = RandomScenario(random).Run().steps;
    std::sort(steps.begin(), steps.end());
    EXPECT_EQ(std::adjacent_find(steps.begin(), steps.end()), steps.end()) << seed;
  }
}

TEST(DecideProperties, TheSameKnowledgeGivesTheSameJudgement) {
  std::mt19937 random(20);
  for (int seed = 0; seed < 100; ++seed) {
    DoorScenario scenario = RandomScenario(random);
    const DoorRun run = scenario.Run();
    EXPECT_EQ(Text(std::get<DoorJudgement>(Decide(run.knowledge))), Text(run.judgement)) << seed;
    EXPECT_EQ(Text(scenario.Run().judgement), Text(run.judgement)) << seed;
  }
}

// Nothing is entered, and no link point is made, that the evidence does not support.
TEST(DecideProperties, AKnownMapIsEnteredOnlyIfAComparisonOrTheScansAcceptIt) {
  std::mt19937 random(21);
  int entered = 0;
  int started = 0;
  for (int seed = 0; seed < 400; ++seed) {
    DoorScenario scenario = RandomScenario(random);
    const DoorRun run = scenario.Run();
    const DoorVerdict verdict = ToVerdict(run.judgement);
    if (!verdict.entered_map) continue;
    if (*verdict.entered_map == MapId("new-map")) {
      ++started;
      continue;
    }
    ++entered;
    const bool by_comparison =
        std::any_of(verdict.comparisons.begin(), verdict.comparisons.end(), [&](const DoorComparison& comparison) {
          return comparison.accepted && comparison.map == *verdict.entered_map;
        });
    const auto scans = scenario.book().scans.find(verdict.entered_map->value());
    const bool by_scans = scans != scenario.book().scans.end() && scans->second.location.accepted;
    EXPECT_TRUE(by_comparison || by_scans) << seed << ": " << Text(run.judgement);
  }
  EXPECT_GT(entered, 50);
  EXPECT_GT(started, 50);
}

}  // namespace
}  // namespace enfilade::closure
