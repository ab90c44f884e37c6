// SPDX-License-Identifier: Apache-2.0
#include "core/closure/door_action.h"

#include <gmock/gmock.h>

#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "tests/support/pose_matchers.h"

namespace enfilade::closure {
namespace {

using ::testing::SizeIs;

const LinkPointId kPoint("point");
const MapId kRoom("room");

EnteredMap Entered() { return {.map = kRoom, .T_map_robot = PoseWithCovariance{{1, 2, 0.5}, Eigen::Matrix3d::Zero()}}; }

graph::LinkPoint PointWithId() {
  graph::LinkPoint point;
  point.id = kPoint;
  return point;
}

struct ActionCase {
  const char* what;
  DoorAction action;
  DoorDecision decision;
  bool has_link_point;
  bool enters;
  bool changes;  // an existing link point
};

std::vector<ActionCase> AllActions() {
  return {
      {"unjudged", LeaveUnjudged{}, DoorDecision::kNotJudged, false, false, false},
      {"known", KeepKnownCandidate{kPoint}, DoorDecision::kCandidateKnown, true, false, false},
      {"made", MakeCandidate{PointWithId()}, DoorDecision::kCandidateMade, true, false, false},
      {"recognised", RecogniseLinkPoint{kPoint, Entered()}, DoorDecision::kLinkPointRecognised, true, true, false},
      {"joined", JoinLinkPoint{kPoint, {}, Entered()}, DoorDecision::kLinkPointRecognised, true, true, true},
      {"promoted", PromoteCandidate{kPoint, graph::LinkPointKind::kDoor, {}, Entered()},
       DoorDecision::kCandidatePromoted, true, true, true},
      {"linked", LinkKnownMaps{PointWithId(), Entered()}, DoorDecision::kLinkPointMade, true, true, false},
      {"started", StartMap{{}, PointWithId(), Entered()}, DoorDecision::kLinkPointMade, true, true, false},
  };
}

TEST(DoorAction, EveryActionHasItsVerdict) {
  const std::vector<ActionCase> actions = AllActions();
  EXPECT_THAT(actions, SizeIs(std::variant_size_v<DoorAction> - 1)) << "all but waiting";
  for (const ActionCase& one : actions) {
    const DoorVerdict verdict = ToVerdict({.action = one.action, .reason = "because"});
    EXPECT_EQ(verdict.decision, one.decision) << one.what;
    EXPECT_EQ(verdict.link_point.has_value(), one.has_link_point) << one.what;
    EXPECT_EQ(verdict.entered_map.has_value(), one.enters) << one.what;
    EXPECT_EQ(verdict.T_map_robot.has_value(), one.enters) << one.what;
    EXPECT_EQ(verdict.reason, "because") << one.what;
    if (verdict.link_point) {
      EXPECT_EQ(*verdict.link_point, kPoint) << one.what;
    }
    if (verdict.T_map_robot) {
      EXPECT_EQ(verdict.T_map_robot->pose, (Pose2{1, 2, 0.5})) << one.what;
    }
  }
}

TEST(DoorAction, EveryDecisionHasANameOfItsOwn) {
  std::set<std::string> names;
  for (int i = 1; i <= 6; ++i) names.insert(NameOf(static_cast<DoorDecision>(i)));
  EXPECT_THAT(names, SizeIs(6));
  EXPECT_THAT(names, ::testing::Not(::testing::Contains("?")));
  EXPECT_STREQ(NameOf(static_cast<DoorDecision>(7)), "?");
}

TEST(DoorAction, AnUnjudgedPassageEntersItsNewMapWithoutAPose) {
  const DoorVerdict verdict = ToVerdict({.action = LeaveUnjudged{MapToStart{.id = kRoom}}});
  EXPECT_EQ(verdict.decision, DoorDecision::kNotJudged);
  EXPECT_EQ(verdict.entered_map, kRoom);
  EXPECT_FALSE(verdict.T_map_robot.has_value());
  EXPECT_FALSE(verdict.link_point.has_value());
}

TEST(DoorAction, OnlyActionsOnExistingLinkPointsChangeOne) {
  for (const ActionCase& one : AllActions()) {
    const LinkPointId* changed = FindChangedLinkPoint(one.action);
    EXPECT_EQ(changed != nullptr, one.changes) << one.what;
    if (changed != nullptr) {
      EXPECT_EQ(*changed, kPoint);
    }
  }
  EXPECT_EQ(FindChangedLinkPoint(WaitForMapping{}), nullptr);
}

TEST(DoorAction, TheVerdictKeepsTheComparisonsInTheirOrder) {
  DoorJudgement judgement;
  for (const char* id : {"best", "second"}) judgement.comparisons.emplace_back().link_point = LinkPointId(id);
  const DoorVerdict verdict = ToVerdict(judgement);
  ASSERT_THAT(verdict.comparisons, SizeIs(2));
  EXPECT_EQ(verdict.comparisons[0].link_point, LinkPointId("best"));
  EXPECT_EQ(verdict.comparisons[1].link_point, LinkPointId("second"));
}

TEST(DescribeNewMap, PrefersTheReportToTheMapThatWasLeft) {
  struct NewMapCase {
    const char* what;
    std::optional<SessionMap> from;
    std::optional<Environment> entered;
    std::optional<std::int32_t> level;
    int expected_level;
    Environment expected_environment;
  };
  const SessionMap garden{.id = MapId("garden"), .level = 3, .environment = Environment::kOutdoor};
  const std::vector<NewMapCase> cases = {
      {"as the map that was left", garden, std::nullopt, std::nullopt, 3, Environment::kOutdoor},
      {"into a building", garden, Environment::kIndoor, std::nullopt, 3, Environment::kIndoor},
      {"up the lift", garden, std::nullopt, 4, 4, Environment::kOutdoor},
      {"down to level 0", garden, std::nullopt, 0, 0, Environment::kOutdoor},
      {"no map was left", std::nullopt, std::nullopt, std::nullopt, 0, Environment::kIndoor},
      {"no map was left, outdoors", std::nullopt, Environment::kOutdoor, -2, -2, Environment::kOutdoor},
  };
  DoorClosureOptions options;
  options.indoor_profile = "short-range";
  options.outdoor_profile = "long-range";
  for (const NewMapCase& one : cases) {
    sensor::DoorReport report;
    report.entered_environment = one.entered;
    report.entered_level = one.level;
    const MapToStart map = DescribeNewMap(kRoom, one.from ? &*one.from : nullptr, &report, options);
    EXPECT_EQ(map.id, kRoom) << one.what;
    EXPECT_EQ(map.level, one.expected_level) << one.what;
    EXPECT_EQ(map.environment, one.expected_environment) << one.what;
    EXPECT_EQ(map.slam_profile, one.expected_environment == Environment::kOutdoor ? "long-range" : "short-range")
        << one.what;
  }
}

TEST(DescribeNewMap, NeedsNeitherMapNorReport) {
  const MapToStart map = DescribeNewMap(kRoom, nullptr, nullptr, {});
  EXPECT_EQ(map.level, 0);
  EXPECT_EQ(map.environment, Environment::kIndoor);
  EXPECT_EQ(map.slam_profile, "") << "the server's own";
}

}  // namespace
}  // namespace enfilade::closure
