// SPDX-License-Identifier: Apache-2.0
// What Decide asks for, in which order, and what scans decide.
#include <gmock/gmock.h>

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "core/closure/decide.h"
#include "tests/support/pose_matchers.h"
#include "tests/unit/core/closure/door_scenario.h"

namespace enfilade::closure {
namespace {

using ::enfilade::testing::PoseNear;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;

constexpr Pose2 kRoomPose{2, 0, 0};  // the robot's, in the room

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
  scenario.Agree("with-cloud", "room", kRoomPose, 60);
  scenario.Agree("side", "room", kRoomPose, 40);
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
  scenario.LocateIn("room", kRoomPose);
  const DoorRun run = scenario.Run();
  EXPECT_THAT(run.steps,
              ElementsAre("graph:door", "graph:places", "images:side", "clouds:side", "graph:maps", "scans:room"));
  const auto action = ActionOf<LinkKnownMaps>(run.judgement);
  EXPECT_EQ(action.entered.map, MapId("room"));
  EXPECT_THAT(action.entered.T_map_robot->pose, PoseNear(kRoomPose, 1e-9, 1e-9));
  EXPECT_THAT(run.judgement.reason, AllOf(HasSubstr("another door of a map that is known"),
                                          HasSubstr("the scans show where the robot is: 80 % on walls")));
  EXPECT_THAT(run.judgement.comparisons, SizeIs(1)) << "what was compared before is still reported";
}

TEST(DecideScans, AreNotMatchedIfThereIsNothingBehindTheDoor) {
  DoorScenario scenario;
  scenario.LocateIn("room", kRoomPose);
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
    scenario.LocateIn("room", kRoomPose);
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
    scenario.LocateIn("room", kRoomPose);
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
  scenario.LocateIn("room", kRoomPose);
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
  scenario.LocateIn("room", kRoomPose);
  scenario.book().scans["hall"].mapping = true;
  EXPECT_THAT(ActionOf<WaitForMapping>(scenario.Run().judgement).maps, ElementsAre("The hall"));
  scenario.book().scans["hall"].mapping = false;
  EXPECT_EQ(ActionOf<LinkKnownMaps>(scenario.Run().judgement).entered.map, MapId("room"));
}

TEST(DecideScans, AMapThatFitsIsNotWaitedFor) {
  DoorScenario scenario;
  scenario.LocateIn("room", kRoomPose);
  scenario.book().scans["room"].recording = true;
  EXPECT_EQ(ActionOf<LinkKnownMaps>(scenario.Run().judgement).entered.map, MapId("room"));
}

}  // namespace
}  // namespace enfilade::closure
