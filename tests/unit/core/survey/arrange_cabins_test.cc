// SPDX-License-Identifier: Apache-2.0
// The cabins of lifts, which are maps of one level and entered from others, too.
#include <algorithm>
#include <cmath>

#include "core/survey/arrange_maps.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/unit/core/survey/drawn_level.h"

namespace enfilade::survey {
namespace {

constexpr Pose2 kPlaceC{-1.0, 2.0, 0.4};

using ::testing::IsEmpty;
using ::testing::SizeIs;

// The corridor is on another level than the one that the cabin was first entered from, and the server did not recognise
// the cabin behind a door (d2) that the graph knows from another drive (d1).
LevelSurvey CorridorWithLift() {
  LevelSurvey survey;
  const Pose2 T_level_cabin{3.0, -2.0, 0.7};
  const Pose2 door{1.5, 2.75, M_PI / 2};
  survey.drives = {MakeDrive(
      {{"s1", "a", {}, {{9.0, 4.0}, {1.5, 4.0}, {1.5, 3.4}}}, {"s2", "b", kPlaceB, {{1.5, 2.0}, {3.0, 1.0}}}})};
  survey.maps = {{.id = MapId("a"), .root = true}, {.id = MapId("b")}};
  survey.link_points = {Join("d1", AnchorAt("cabin", T_level_cabin, door), AnchorAt("a", {}, door)),
                        Join("d2", AnchorAt("a", {}, door), AnchorAt("b", kPlaceB, door)),
                        Join("d3", AnchorAt("b", kPlaceB, door), AnchorAt("lobby", {}, {}))};
  survey.cabins = {MapId("cabin")};
  return survey;
}

TEST(ArrangeCabins, ACabinOfALiftIsOneMapOnAllLevels) {
  const LevelSurvey survey = CorridorWithLift();
  const rearrange::Rearrangement change = Arrange(survey);
  EXPECT_TRUE(rearrange::Validate(change).ok());
  EXPECT_THAT(change.new_maps, IsEmpty());
  ASSERT_THAT(change.moves, SizeIs(1));
  EXPECT_EQ(change.moves[0].session, SessionId("s2"));
  EXPECT_EQ(change.moves[0].to, MapId("cabin"));
  const Pose2 T_cabin_b = Between({3.0, -2.0, 0.7}, kPlaceB);
  EXPECT_NEAR(change.moves[0].T_to_from.x, T_cabin_b.x, 1e-6);
  EXPECT_NEAR(change.moves[0].T_to_from.y, T_cabin_b.y, 1e-6);
  EXPECT_NEAR(change.moves[0].T_to_from.yaw, T_cabin_b.yaw, 1e-6);
  ASSERT_THAT(change.redirects, SizeIs(1));
  EXPECT_EQ(change.redirects[0].from, MapId("b"));
  EXPECT_EQ(change.redirects[0].to, MapId("cabin"));
  EXPECT_EQ(JoinedMaps(After(survey, change)),
            (std::multiset<std::set<std::string>>{{"a", "cabin"}, {"cabin", "lobby"}}))
      << "the cabin's door of the other level stays";
}

// The door's anchors were made when the robot came out of the cabin. The survey has seen since how the hall lies.
TEST(ArrangeCabins, TheHallsAnchorIsWhereRobotsBroughtTheCabin) {
  const Pose2 T_level_cabin{3.0, -2.0, 0.7};
  const Pose2 door{1.5, 2.75, M_PI / 2};  // looks out of the cabin
  LevelSurvey survey;
  survey.drives = {MakeDrive({{"s1", "a", {}, {{1.5, 4.0}, {9.0, 4.0}}}})};
  survey.maps = {{.id = MapId("a"), .root = true}};
  survey.link_points = {Join("d1", AnchorAt("cabin", T_level_cabin, door), AnchorAt("a", {}, door))};
  survey.link_points[0].direction = MapId("a");
  survey.cabins = {MapId("cabin")};
  survey.cabin_places[MapId("cabin")] = T_level_cabin * Pose2{0.05, 0.0, 0.02};
  const rearrange::Rearrangement change = Arrange(survey);
  EXPECT_TRUE(rearrange::Validate(change).ok());
  const LevelSurvey after = After(survey, change);
  const auto found = std::find_if(after.link_points.begin(), after.link_points.end(),
                                  [](const graph::LinkPoint& one) { return one.id == LinkPointId("d1"); });
  ASSERT_NE(found, after.link_points.end());
  const Pose2 T_a_cabin =
      found->FindAnchor(MapId("a"))->T_map_place * Inverse(found->FindAnchor(MapId("cabin"))->T_map_place);
  const Pose2 expected = T_level_cabin * Pose2{0.05, 0.0, 0.02};  // a lies where the level does
  EXPECT_NEAR(T_a_cabin.x, expected.x, 1e-6);
  EXPECT_NEAR(T_a_cabin.y, expected.y, 1e-6);
  EXPECT_NEAR(T_a_cabin.yaw, expected.yaw, 1e-6);
  EXPECT_EQ(found->FindAnchor(MapId("cabin"))->T_map_place,
            survey.link_points[0].FindAnchor(MapId("cabin"))->T_map_place);
  EXPECT_TRUE(Arrange(after).empty());
}

// The robot passes the door on this level. Where the cabin is there, it knows by the ride that brought it.
TEST(ArrangeCabins, ADoorToACabinThatBroughtRobotsIsNoSurerThanTheRide) {
  const auto yaw_variance = [](const LevelSurvey& survey, const std::string& map) {
    const LevelSurvey after = After(survey, Arrange(survey));
    EXPECT_TRUE(Arrange(after).empty());
    for (const graph::LinkPoint& door : after.link_points) {
      const graph::Anchor* anchor = door.FindAnchor(MapId(map));
      if (anchor != nullptr && door.FindAnchor(MapId("a")) != nullptr && door.FindAnchor(MapId("cabin")) != nullptr) {
        return anchor->covariance(2, 2);
      }
    }
    ADD_FAILURE() << "nothing joins the corridor and the cabin";
    return 0.0;
  };
  const LevelSurvey survey = CorridorWithLift();
  LevelSurvey brought = survey;
  brought.cabin_places[MapId("cabin")] = {3.0, -2.0, 0.7};
  const double ride = std::pow(SurveyOptions().ride_yaw_sigma, 2);
  EXPECT_GT(yaw_variance(brought, "a"), ride);
  EXPECT_LT(yaw_variance(brought, "cabin"), ride) << "it counts once";
  EXPECT_LT(yaw_variance(survey, "a"), ride) << "no ride shows where the cabin is";
}

// The robot's next ride began where the level's map shows it, and found a door on another level.
TEST(ArrangeCabins, ARideLiesInItsCabinWhereItsLevelHasIt) {
  LevelSurvey survey = CorridorWithLift();
  const Pose2 T_level_cabin{3.0, -2.0, 0.7};
  survey.cabin_places[MapId("cabin")] = T_level_cabin;
  survey.link_points.push_back(
      Join("d4", AnchorAt("cabin", T_level_cabin, {1.5, 2.75, M_PI / 2}), AnchorAt("attic", {}, {})));
  const Pose2 T_cabin_robot{0.5, 0.3, 1.0};
  const Pose2 T_to_from{0.1, -0.05, 0.03};
  RideBegun ride{.session = SessionId("s9"),
                 .cabin = MapId("cabin"),
                 .T_level_robot = T_level_cabin * T_to_from * T_cabin_robot,
                 .T_cabin_robot = T_cabin_robot,
                 .way_out = LinkPointId("d4")};
  survey.rides_begun = {ride};
  const rearrange::Rearrangement change = Arrange(survey);
  EXPECT_TRUE(rearrange::Validate(change).ok());
  const auto move = std::find_if(change.moves.begin(), change.moves.end(),
                                 [](const rearrange::SessionMove& one) { return one.session == SessionId("s9"); });
  ASSERT_NE(move, change.moves.end());
  EXPECT_EQ(move->to, MapId("cabin"));
  EXPECT_NEAR(move->T_to_from.x, T_to_from.x, 1e-6);
  EXPECT_NEAR(move->T_to_from.y, T_to_from.y, 1e-6);
  EXPECT_NEAR(move->T_to_from.yaw, T_to_from.yaw, 1e-6);
  const auto door = std::find_if(change.link_points.begin(), change.link_points.end(),
                                 [](const graph::LinkPoint& one) { return one.id == LinkPointId("d4"); });
  ASSERT_NE(door, change.link_points.end()) << "what the ride has found moves with it";
  const Pose2 expected = T_to_from * AnchorAt("cabin", T_level_cabin, {1.5, 2.75, M_PI / 2}).T_map_place;
  EXPECT_NEAR(door->FindAnchor(MapId("cabin"))->T_map_place.x, expected.x, 1e-6);
  EXPECT_NEAR(door->FindAnchor(MapId("cabin"))->T_map_place.y, expected.y, 1e-6);

  ride.T_cabin_robot = T_to_from * T_cabin_robot;
  survey.rides_begun = {ride};
  const rearrange::Rearrangement next = Arrange(survey);
  EXPECT_TRUE(std::none_of(next.moves.begin(), next.moves.end(),
                           [](const rearrange::SessionMove& one) { return one.session == SessionId("s9"); }));
}

// The cabin was left for the lobby's level in both of its maps. The lobby is not of this level.
TEST(ArrangeCabins, ADoorOfAnotherLevelIsOneLinkPoint) {
  LevelSurvey survey = CorridorWithLift();
  survey.link_points.push_back(
      Join("d0", AnchorAt("cabin", {3.0, -2.0, 0.7}, {1.5, 2.75, M_PI / 2}), AnchorAt("lobby", {}, {})));
  survey.link_points[2] = Join("d3", AnchorAt("b", kPlaceB, {1.5, 2.75, M_PI / 2}), AnchorAt("lobby", {}, {}));
  const rearrange::Rearrangement change = Arrange(survey);
  EXPECT_TRUE(rearrange::Validate(change).ok());
  EXPECT_EQ(JoinedMaps(After(survey, change)),
            (std::multiset<std::set<std::string>>{{"a", "cabin"}, {"cabin", "lobby"}}));
}

// A robot came out of the lift and went on into a room, which is its map now.
TEST(ArrangeCabins, ACabinIsFoundThoughTheMapInFrontOfItIsAnotherRooms) {
  LevelSurvey survey = CorridorWithLift();
  survey.drives.insert(survey.drives.begin(), MakeDrive({{"s0", "c", kPlaceC, {{1.5, 3.4}, {5.0, 4.0}, {5.0, 7.0}}},
                                                         {"s4", "c", kPlaceC, {{5.0, 7.0}, {3.2, 7.0}, {5.0, 7.0}}}}));
  survey.maps.push_back({.id = MapId("c")});
  survey.link_points[0].anchors[1] = AnchorAt("c", kPlaceC, {1.5, 2.75, M_PI / 2});
  survey.link_points[0].direction = MapId("c");
  const rearrange::Rearrangement change = Arrange(survey);
  EXPECT_TRUE(rearrange::Validate(change).ok());
  EXPECT_EQ(JoinedMaps(After(survey, change)),
            (std::multiset<std::set<std::string>>{{"a", "c"}, {"a", "cabin"}, {"cabin", "lobby"}}));
}

// A robot that came out of the cabin began map b in the corridor, and went on into the room that b is now.
TEST(ArrangeCabins, TheDoorThatRobotsComeOutOfStaysTheCorridors) {
  const Pose2 out{1.5, 2.75, M_PI / 2};
  LevelSurvey survey;
  survey.drives = {MakeDrive({{"s1", "a", {}, {{9.0, 4.0}, {1.5, 4.0}, {1.5, 3.4}}}}),
                   MakeDrive({{"s2", "b", kPlaceB, {{1.5, 3.4}, {1.5, 4.0}, {5.0, 4.0}, {5.0, 7.0}, {3.2, 7.0}}}})};
  survey.maps = {{.id = MapId("a"), .root = true}, {.id = MapId("b")}};
  survey.link_points = {Join("d1", AnchorAt("a", {}, out), AnchorAt("cabin", {3.0, -2.0, 0.7}, out)),
                        Join("d2", AnchorAt("cabin", {3.0, -2.0, 0.7}, out), AnchorAt("b", kPlaceB, out))};
  survey.cabins = {MapId("cabin")};
  const rearrange::Rearrangement change = Arrange(survey);
  EXPECT_TRUE(rearrange::Validate(change).ok());
  EXPECT_EQ(JoinedMaps(After(survey, change)), (std::multiset<std::set<std::string>>{{"a", "b"}, {"a", "cabin"}}));
}

// The same in the level of the cabin's map: the robot that came out had entered the cabin on another level.
TEST(ArrangeCabins, TheDoorThatARideEndsAtStaysTheCorridors) {
  const Pose2 out{1.5, 2.75, M_PI / 2};
  LevelSurvey survey;
  survey.drives = {MakeDrive({{"s1", "a", {}, {{9.0, 4.0}, {1.5, 4.0}, {1.5, 3.4}}},
                              {"s2", "b", kPlaceB, {{1.5, 2.0}, {3.0, 1.0}}}}),
                   MakeDrive({{"s3", "c", kPlaceC, {{1.5, 3.4}, {1.5, 4.0}, {5.0, 4.0}, {5.0, 7.0}, {3.2, 7.0}}}})};
  survey.maps = {
      {.id = MapId("a"), .root = true}, {.id = MapId("b"), .rides = {{SessionId("r"), {}}}}, {.id = MapId("c")}};
  survey.link_points = {Join("d1", AnchorAt("a", {}, out), AnchorAt("b", kPlaceB, out)),
                        Join("d2", AnchorAt("b", kPlaceB, out), AnchorAt("c", kPlaceC, out))};
  const rearrange::Rearrangement change = Arrange(survey);
  EXPECT_TRUE(rearrange::Validate(change).ok());
  EXPECT_EQ(JoinedMaps(After(survey, change)), (std::multiset<std::set<std::string>>{{"a", "b"}, {"a", "c"}}));
}

// A robot went out of each of the cabin's two maps to the lobby's level.
TEST(ArrangeCabins, ADoorOfThreeMapsStaysWhenTwoOfThemAreOneRoom) {
  LevelSurvey survey = CorridorWithLift();
  survey.link_points[2].anchors.push_back(AnchorAt("cabin", {3.0, -2.0, 0.7}, {1.5, 2.75, M_PI / 2}));
  const rearrange::Rearrangement change = Arrange(survey);
  EXPECT_TRUE(rearrange::Validate(change).ok());
  ASSERT_THAT(change.redirects, SizeIs(1));
  EXPECT_EQ(JoinedMaps(After(survey, change)),
            (std::multiset<std::set<std::string>>{{"a", "cabin"}, {"cabin", "lobby"}}));
}

TEST(ArrangeCabins, RidesGoWithTheirCabinAndNowhereElse) {
  LevelSurvey survey = CorridorWithLift();
  survey.maps[1].rides = {{SessionId("r"), {}}};
  const rearrange::Rearrangement change = Arrange(survey);
  EXPECT_TRUE(rearrange::Validate(change).ok());
  ASSERT_THAT(change.moves, SizeIs(2));
  EXPECT_EQ(change.moves[1].session, SessionId("r"));
  EXPECT_EQ(change.moves[1].to, MapId("cabin"));
  EXPECT_NEAR(change.moves[1].T_to_from.x, change.moves[0].T_to_from.x, 1e-9);
  ASSERT_THAT(change.redirects, SizeIs(1));
  EXPECT_EQ(change.redirects[0].from, MapId("b"));

  LevelSurvey doubled = DoubledCorridor();
  doubled.maps[2].rides = {{SessionId("r"), {}}};  // nobody knows where it is on this level
  EXPECT_THAT(Arrange(doubled).redirects, IsEmpty());
}

TEST(ArrangeCabins, ASuspendedLinkPointShowsNoCabin) {
  LevelSurvey survey = CorridorWithLift();
  survey.link_points[0].use = graph::LinkPointUse::kSuspended;
  EXPECT_THAT(Arrange(survey).redirects, IsEmpty());
}

// Sessions end at the door: what is behind it is not of this level.
TEST(ArrangeCabins, ADoorToACabinStaysThoughNobodyWasSeenBehindIt) {
  LevelSurvey survey = CorridorWithLift();
  survey.drives[0].pop_back();
  survey.maps.pop_back();
  survey.link_points.resize(1);
  EXPECT_TRUE(Arrange(survey).empty()) << Arrange(survey).reason;
}

// The cabin's door of the other level was found when map b was the cabin; now it is the corridor, and a the cabin.
TEST(ArrangeCabins, ADoorToAnotherLevelStaysTheCabinsIfMapsExchangeTheirRooms) {
  const Pose2 out{1.5, 2.75, M_PI / 2};
  LevelSurvey survey;
  survey.drives = {MakeDrive(
      {{"s1", "b", kPlaceB, {{9.0, 4.0}, {1.5, 4.0}, {1.5, 3.4}}}, {"s2", "a", {}, {{1.5, 2.0}, {3.0, 1.0}}}})};
  survey.maps = {{.id = MapId("a")}, {.id = MapId("b")}};
  survey.link_points = {Join("d1", AnchorAt("a", {}, out), AnchorAt("b", kPlaceB, out)),
                        Join("d2", AnchorAt("b", kPlaceB, out), AnchorAt("upstairs", {}, {}))};
  const LevelSurvey after = After(survey, Arrange(survey));
  EXPECT_EQ(JoinedMaps(after), (std::multiset<std::set<std::string>>{{"a", "b"}, {"a", "upstairs"}}));

  // Entered from upstairs: the cabin is ahead.
  survey.link_points[1] = Join("d2", AnchorAt("upstairs", {}, {}), AnchorAt("b", kPlaceB, {1.5, 2.75, -M_PI / 2}));
  const rearrange::Rearrangement change = Arrange(survey);
  EXPECT_EQ(JoinedMaps(After(survey, change)), JoinedMaps(after));
  const auto moved = std::find_if(change.link_points.begin(), change.link_points.end(),
                                  [](const graph::LinkPoint& one) { return one.id == LinkPointId("d2"); });
  ASSERT_NE(moved, change.link_points.end());
  EXPECT_EQ(moved->direction, MapId("a"));
}

TEST(ArrangeCabins, RidesStayInTheirCabinIfMapsExchangeTheirRooms) {
  LevelSurvey survey;
  survey.drives = {MakeDrive(
      {{"s1", "b", kPlaceB, {{9.0, 4.0}, {1.5, 4.0}, {1.5, 3.4}}}, {"s2", "a", {}, {{1.5, 2.0}, {3.0, 1.0}}}})};
  std::vector<Pose2> seen;
  for (const double y : {3.2, 2.0, 1.0}) seen.push_back(Between(kPlaceB, {2.0, y, 0.0}));  // in room 2, but for one
  survey.maps = {{.id = MapId("a")}, {.id = MapId("b"), .rides = {{SessionId("r"), seen}}}};
  const rearrange::Rearrangement change = Arrange(survey);
  EXPECT_TRUE(rearrange::Validate(change).ok());
  ASSERT_THAT(change.moves, SizeIs(1));
  EXPECT_EQ(change.moves[0].session, SessionId("r"));
  EXPECT_EQ(change.moves[0].to, MapId("a"));
  EXPECT_NEAR(change.moves[0].T_to_from.x, kPlaceB.x, 1e-6);
  EXPECT_NEAR(change.moves[0].T_to_from.y, kPlaceB.y, 1e-6);
  EXPECT_NEAR(change.moves[0].T_to_from.yaw, kPlaceB.yaw, 1e-6);
}

// The corridor's session went on in the cabin until the detector was sure of the door.
LevelSurvey WaitingInTheCabin() {
  LevelSurvey survey = CorridorWithLift();
  survey.maps.pop_back();
  survey.link_points.resize(1);
  Drive& drive = survey.drives[0];
  drive.pop_back();
  drive[0].cabin = CabinEntry{.cabin = MapId("cabin"), .door = LinkPointId("d1")};
  for (const double ahead : {0.1, 0.4, 0.7}) {
    const std::int64_t sequence = drive[0].visits.back().sequence + 5 * static_cast<std::int64_t>(1 + 10 * ahead);
    drive[0].cabin->visits.push_back({sequence, 0, {1.5, 2.75 - ahead, -M_PI / 2}, {}});
  }
  return survey;
}

TEST(ArrangeCabins, WhatASessionRecordsInTheCabinIsCutOff) {
  const LevelSurvey survey = WaitingInTheCabin();
  const rearrange::Rearrangement change = Arrange(survey);
  EXPECT_TRUE(rearrange::Validate(change).ok());
  ASSERT_THAT(change.cuts, SizeIs(1));
  EXPECT_EQ(change.cuts[0].session, SessionId("s1"));
  EXPECT_EQ(change.cuts[0].first_sequence, survey.drives[0][0].cabin->visits.front().sequence);
  ASSERT_THAT(change.moves, SizeIs(1));
  EXPECT_EQ(change.moves[0].session, change.cuts[0].rest);
  EXPECT_EQ(change.moves[0].to, MapId("cabin"));
  const Pose2 T_cabin_corridor = Inverse(Pose2{3.0, -2.0, 0.7});
  EXPECT_NEAR(change.moves[0].T_to_from.x, T_cabin_corridor.x, 1e-6);
  EXPECT_NEAR(change.moves[0].T_to_from.y, T_cabin_corridor.y, 1e-6);
  EXPECT_NEAR(change.moves[0].T_to_from.yaw, T_cabin_corridor.yaw, 1e-6);
  EXPECT_THAT(change.link_points, IsEmpty());
  EXPECT_THAT(change.removed_link_points, IsEmpty());
}

TEST(ArrangeCabins, NothingIsCutOffAtTheCabinsDoorstepOrByASuspendedLinkPoint) {
  LevelSurvey survey = WaitingInTheCabin();
  survey.drives[0][0].cabin->visits.pop_back();
  EXPECT_TRUE(Arrange(survey).empty()) << Arrange(survey).reason;
  survey = WaitingInTheCabin();
  survey.link_points[0].use = graph::LinkPointUse::kSuspended;
  EXPECT_THAT(Arrange(survey).cuts, IsEmpty());
}

TEST(ArrangeCabins, ABusyMapOrTheRootIsNoCabin) {
  LevelSurvey survey = CorridorWithLift();
  survey.maps[1].busy = true;
  EXPECT_THAT(Arrange(survey).redirects, IsEmpty());
  survey = CorridorWithLift();
  survey.maps[1].root = true;
  survey.maps[0].root = false;
  EXPECT_THAT(Arrange(survey).redirects, IsEmpty());
}

}  // namespace
}  // namespace enfilade::survey
