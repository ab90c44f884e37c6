// SPDX-License-Identifier: Apache-2.0
// Properties of Decide that hold for any knowledge.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/closure/decide.h"
#include "tests/unit/core/closure/door_scenario.h"

namespace enfilade::closure {
namespace {

constexpr Pose2 kRobotBehindDoor{2, 0, 0};  // in the room

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
    scenario.Agree("upstairs", "attic", kRobotBehindDoor, 400);
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
