// SPDX-License-Identifier: Apache-2.0
// What people have decided of maps and link points stays.
#include "core/survey/arrange_maps.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/unit/core/survey/drawn_level.h"

namespace enfilade::survey {
namespace {

using ::testing::Contains;
using ::testing::Each;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

SurveyedMap& MapOf(LevelSurvey& survey, const std::string& id) {
  return *std::find_if(survey.maps.begin(), survey.maps.end(),
                       [&](const SurveyedMap& map) { return map.id == MapId(id); });
}

// One session through the corridor and far into the south room: people have merged both.
LevelSurvey TwoRoomsInOneMap() {
  LevelSurvey survey;
  survey.drives = {MakeDrive({{"s", "a", {}, {{1.5, 1.0}, {3.5, 0.5}, {1.5, 1.0}, {1.5, 4.0}, {9.0, 4.0}}}})};
  survey.maps = {{.id = MapId("a"), .root = true, .pinned = true}};
  return survey;
}

TEST(ArrangePinned, APinnedMapOfTwoRoomsStaysOne) {
  LevelSurvey survey = TwoRoomsInOneMap();
  EXPECT_TRUE(Arrange(survey).empty());
  MapOf(survey, "a").pinned = false;
  EXPECT_THAT(Arrange(survey).new_maps, SizeIs(1));
}

TEST(ArrangePinned, AllRoomsOfASessionOfAPinnedMapAreOneMap) {
  LevelSurvey survey;
  survey.drives = {MakeDrive({{"s",
                               "a",
                               {},
                               {{1.5, 1.0},
                                {3.5, 0.5},
                                {1.5, 1.0},
                                {1.5, 4.0},
                                {5.0, 4.0},
                                {5.0, 7.0},
                                {3.5, 7.0},
                                {5.0, 7.0},
                                {5.0, 4.0},
                                {9.0, 4.0}}}}),
                   MakeDrive({{"t", "b", {}, {{3.5, 6.0}, {5.5, 6.0}, {5.5, 7.0}, {3.5, 7.0}}}})};
  survey.maps = {{.id = MapId("a"), .root = true, .pinned = true}, {.id = MapId("b")}};
  const rearrange::Rearrangement change = Arrange(survey);
  ASSERT_THAT(change.moves, SizeIs(1));
  EXPECT_EQ(change.moves[0].session, SessionId("t"));
  EXPECT_EQ(change.moves[0].to, MapId("a"));
  EXPECT_THAT(change.cuts, IsEmpty());
}

TEST(ArrangePinned, WhatRobotsRecordLaterInItsRoomsJoinsIt) {
  LevelSurvey survey = TwoRoomsInOneMap();
  // A longer drive in the south room, in a map that a verdict began.
  survey.drives.push_back(MakeDrive(
      {{"t", "b", {1.0, 1.0, 0.3}, {{0.5, 0.5}, {3.5, 0.5}, {3.5, 2.0}, {0.5, 2.0}, {0.5, 0.5}, {3.5, 0.5}}}}));
  survey.maps.push_back({.id = MapId("b")});
  const rearrange::Rearrangement change = Arrange(survey);
  EXPECT_THAT(change.cuts, IsEmpty());
  ASSERT_THAT(change.moves, SizeIs(1));
  EXPECT_EQ(change.moves[0].session, SessionId("t"));
  EXPECT_EQ(change.moves[0].to, MapId("a"));
  ASSERT_THAT(change.redirects, SizeIs(1));
  const LevelSurvey after = After(survey, change);
  EXPECT_THAT(MapsOfRooms(after, Corridor()).at(2), Each("a"));
  EXPECT_TRUE(Arrange(after).empty());
}

// A wrong verdict has put into the pinned map what a robot recorded in another room.
TEST(ArrangePinned, WhatIsRecordedLaterInAnotherMapsRoomClaimsItNot) {
  LevelSurvey survey;
  survey.drives = {
      MakeDrive({{"s", "a", {}, {{9.0, 4.0}, {1.5, 4.0}, {1.5, 3.0}}},
                 {"t", "b", {}, {{1.5, 2.0}, {3.5, 0.5}, {0.5, 0.5}, {3.5, 0.5}, {0.5, 0.5}}}}),
      MakeDrive({{"u", "a", {}, {{9.0, 4.0}, {1.5, 4.0}, {1.5, 0.5}, {3.5, 0.5}, {0.5, 0.5}, {3.5, 0.5}}}})};
  for (Visit& visit : survey.drives[1][0].visits) visit.time += 1'000'000'000'000;
  survey.maps = {{.id = MapId("a"), .root = true, .pinned = true}, {.id = MapId("b")}};
  EXPECT_THAT(Arrange(survey).redirects, IsEmpty());
  EXPECT_THAT(Arrange(survey).moves, IsEmpty());
  // Had it been there first, the room would be the pinned map's, as that of all its sessions.
  for (Visit& visit : survey.drives[0][1].visits) visit.time += 2'000'000'000'000;
  EXPECT_THAT(Arrange(survey).redirects, SizeIs(1));
}

// A session ends behind the door that it reports: that is no decision about the next room.
TEST(ArrangePinned, TheEndOfASessionBehindItsDoorTakesNoRoom) {
  LevelSurvey survey = DoubledCorridor();
  MapOf(survey, "a").pinned = true;
  LevelSurvey after = After(survey, Arrange(survey));
  EXPECT_EQ(after.drives[0][0].map, MapId("a"));
  EXPECT_THAT(after.drives[0][0].visits, SizeIs(survey.drives[0][0].visits.size())) << "it is not cut";
  EXPECT_THAT(MapsOfRooms(after, Corridor()).at(2), Contains("b"));
  EXPECT_THAT(JoinedMaps(after), Contains(std::set<std::string>{"a", "b"}));
  EXPECT_TRUE(Arrange(after).empty());
}

TEST(ArrangePinned, TheEndsOfManySessionsTakeNoRoomEither) {
  LevelSurvey survey;
  for (int i = 0; i < 4; ++i) {
    const std::string n = std::to_string(i);
    survey.drives.push_back(MakeDrive(
        {{"s" + n, "a", {}, {{9.0, 4.0}, {1.5, 4.0}, {1.5, 0.5}}}, {"t" + n, "b", {}, {{1.5, 0.5}, {3.5, 0.5}}}}));
  }
  survey.maps = {{.id = MapId("a"), .root = true, .pinned = true}, {.id = MapId("b")}};
  survey.drives.push_back(MakeDrive({{"u", "b", {}, {{3.5, 0.5}, {0.5, 0.5}, {3.5, 0.5}, {0.5, 0.5}, {3.5, 0.5}}}}));
  EXPECT_THAT(Arrange(survey).redirects, IsEmpty());
  EXPECT_THAT(Arrange(survey).moves, IsEmpty());
}

// People have split the corridor in two, and an opening joins both.
TEST(ArrangePinned, TwoPinnedMapsOfOneRoomStayTwoWithTheirLinkPoints) {
  LevelSurvey survey;
  survey.drives = {MakeDrive({{"s1", "a", {}, {{9.0, 4.0}, {5.0, 4.0}}},
                              {"s2", "b", kPlaceB, {{5.0, 4.0}, {1.5, 4.0}, {1.5, 3.0}}},
                              {"s3", "c", {}, {{1.5, 2.0}, {3.0, 1.0}}}})};
  survey.maps = {
      {.id = MapId("a"), .root = true, .pinned = true}, {.id = MapId("b"), .pinned = true}, {.id = MapId("c")}};
  const Pose2 opening{5.0, 4.0, M_PI};
  const Pose2 door{1.5, 2.75, -M_PI / 2};
  survey.link_points = {Join("opening", AnchorAt("a", {}, opening), AnchorAt("b", kPlaceB, opening)),
                        Join("door", AnchorAt("b", kPlaceB, door), AnchorAt("c", {}, door))};
  survey.link_points[0].kind = graph::LinkPointKind::kOpening;
  EXPECT_TRUE(Arrange(survey).empty());
  MapOf(survey, "a").pinned = MapOf(survey, "b").pinned = false;
  EXPECT_THAT(Arrange(survey).redirects, SizeIs(1));
}

TEST(ArrangePinned, ASessionStaysWhereItLies) {
  LevelSurvey survey = CorridorDrivenThreeTimes({0.3, 0.0, 0.0});
  EXPECT_FALSE(Arrange(survey).empty());
  MapOf(survey, "a").pinned = true;
  EXPECT_TRUE(Arrange(survey).empty());
}

TEST(ArrangePinned, ALinkPointStaysThoughNobodyWentThroughIt) {
  LevelSurvey survey = DoubledCorridor();
  survey = After(survey, Arrange(survey));
  const Pose2 unused{3.5, 2.75, -M_PI / 2};
  survey.link_points.push_back(Join("unused", AnchorAt("a", {}, unused), AnchorAt("b", {1.0, 1.0, 0.3}, unused)));
  EXPECT_THAT(Arrange(survey).removed_link_points, Contains(LinkPointId("unused")));
  survey.link_points.back().pinned = true;
  EXPECT_TRUE(Arrange(survey).empty());
}

TEST(ArrangePinned, ALinkPointStaysWherePeopleHavePutIt) {
  LevelSurvey survey = DoubledCorridor();
  survey = After(survey, Arrange(survey));
  ASSERT_THAT(survey.link_points, SizeIs(1));
  graph::LinkPoint& door = survey.link_points[0];
  for (graph::Anchor& anchor : door.anchors) {
    if (anchor.map == MapId("b")) anchor.T_map_place.x += 0.4;
    anchor.covariance = Eigen::Vector3d(0.01, 0.01, 0.0012).asDiagonal();  // as `enfilade linkpoint move` has it
  }
  EXPECT_THAT(Arrange(survey).link_points, SizeIs(1)) << "the survey knows it better";
  door.pinned = true;
  EXPECT_TRUE(Arrange(survey).empty());
}

TEST(ArrangePinned, ALinkPointOfMapsThatBecomeOneDisappears) {
  LevelSurvey survey = DoubledCorridor();
  const Pose2 inside{6.0, 4.0, 0.0};
  survey.link_points.push_back(Join("pinned", AnchorAt("a", {}, inside), AnchorAt("c", kPlaceB, inside)));
  survey.link_points.back().pinned = true;
  EXPECT_THAT(Arrange(survey).removed_link_points, Contains(LinkPointId("pinned")));
}

TEST(ArrangePinned, ACandidateThatPeopleHaveMadeStays) {
  LevelSurvey survey = DoubledCorridor();
  survey = After(survey, Arrange(survey));
  graph::LinkPoint candidate;
  candidate.id = LinkPointId("candidate");
  candidate.anchors = {AnchorAt("a", {}, {4.0, 4.0, 0.0})};  // before open ground
  survey.link_points.push_back(candidate);
  EXPECT_THAT(Arrange(survey).removed_link_points, Contains(candidate.id));
  survey.link_points.back().pinned = true;
  EXPECT_THAT(Arrange(survey).removed_link_points, Not(Contains(candidate.id)));
}

}  // namespace
}  // namespace enfilade::survey
