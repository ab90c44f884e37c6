// SPDX-License-Identifier: Apache-2.0
#include "core/survey/arrange_maps.h"

#include "core/graph/same_place.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/survey/drawn_level.h"

namespace enfilade::survey {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;

TEST(ArrangeMaps, TwoMapsOfOneRoomBecomeOne) {
  const LevelSurvey survey = DoubledCorridor();
  const rearrange::Rearrangement change = Arrange(survey);
  EXPECT_TRUE(rearrange::Validate(change).ok());
  // What s1 and s2 recorded behind the door is of the other room.
  ASSERT_THAT(change.cuts, SizeIs(2));
  EXPECT_EQ(change.cuts[0].session, SessionId("s1"));
  EXPECT_EQ(change.cuts[1].session, SessionId("s2"));
  EXPECT_THAT(change.new_maps, IsEmpty());
  ASSERT_THAT(change.moves, SizeIs(3));
  EXPECT_EQ(change.moves[0].to, MapId("b"));
  EXPECT_EQ(change.moves[1].to, MapId("a"));
  EXPECT_EQ(change.moves[2].session, SessionId("s3"));
  EXPECT_EQ(change.moves[2].to, MapId("a"));
  EXPECT_NEAR(change.moves[2].T_to_from.x, kPlaceB.x, 1e-6);
  ASSERT_THAT(change.redirects, SizeIs(1));
  EXPECT_EQ(change.redirects[0].from, MapId("c"));
  EXPECT_EQ(change.redirects[0].to, MapId("a"));
  // One door, one link point.
  EXPECT_THAT(change.removed_link_points, SizeIs(1));
  const LevelSurvey after = After(survey, change);
  EXPECT_EQ(JoinedMaps(after), (std::multiset<std::set<std::string>>{{"a", "b"}}));
  EXPECT_TRUE(Arrange(after).empty());
}

TEST(ArrangeMaps, AMapOfTwoRoomsIsDivided) {
  LevelSurvey survey;
  survey.drives = {MakeDrive({{"s", "a", {}, {{1.5, 1.0}, {1.5, 4.0}, {9.0, 4.0}}}})};
  survey.maps = {{.id = MapId("a"), .environment = Environment::kIndoor, .slam_profile = "fine", .root = true}};
  const rearrange::Rearrangement change = Arrange(survey);
  EXPECT_TRUE(rearrange::Validate(change).ok());
  ASSERT_THAT(change.new_maps, SizeIs(1));
  EXPECT_EQ(change.new_maps[0].slam_profile, "fine");
  EXPECT_EQ(change.new_maps[0].name_prefix, "Map");
  ASSERT_THAT(change.cuts, SizeIs(1));
  EXPECT_EQ(change.cuts[0].session, SessionId("s"));
  ASSERT_THAT(change.link_points, SizeIs(1));
  // The door, seen from both maps, which have the same frame here.
  const graph::LinkPoint& door = change.link_points[0];
  ASSERT_THAT(door.anchors, SizeIs(2));
  EXPECT_NEAR(door.anchors[0].T_map_place.x, 1.5, 1e-6);
  EXPECT_NEAR(door.anchors[0].T_map_place.y, 2.75, 1e-6);
  EXPECT_NEAR(door.anchors[0].T_map_place.yaw, M_PI / 2, 1e-6);  // as the robot went: north
  EXPECT_NEAR(door.anchors[1].T_map_place.y, 2.75, 1e-6);
  const LevelSurvey after = After(survey, change);
  EXPECT_THAT(MapsOfRooms(after, Corridor()).at(1), SizeIs(1));
  EXPECT_NE(MapsOfRooms(after, Corridor()).at(1), MapsOfRooms(after, Corridor()).at(2));
  EXPECT_TRUE(Arrange(after).empty());
}

TEST(ArrangeMaps, ASessionOfManyRoomsIsCutAtEachDoor) {
  std::vector<Eigen::Vector2d> way;
  for (int i = 0; i < 4; ++i) way.insert(way.end(), {{1.5, 1.0}, {1.5, 4.5}});  // eight stretches
  LevelSurvey survey;
  survey.drives = {MakeDrive({{"s", "a", {}, way}})};
  survey.maps = {{.id = MapId("a"), .root = true}};
  const auto new_id = NumberedIds();
  const rearrange::Rearrangement change = ArrangeMaps(survey, Corridor(), {}, new_id);
  ASSERT_THAT(change.cuts, SizeIs(7));
  EXPECT_OK(rearrange::Validate(change));
  for (const rearrange::SessionCut& cut : change.cuts) EXPECT_EQ(cut.session, SessionId("s"));
  survey = After(survey, change);
  EXPECT_THAT(survey.drives[0], SizeIs(8));
  EXPECT_THAT(survey.maps, SizeIs(2));
  EXPECT_TRUE(ArrangeMaps(survey, Corridor(), {}, new_id).empty());
}

TEST(ArrangeMaps, MapsThatAreRoomsStay) {
  LevelSurvey survey;
  survey.drives = {MakeDrive(
      {{"s1", "a", {}, {{9.0, 4.0}, {1.5, 4.0}, {1.5, 3.4}}}, {"s2", "b", {1.0, 1.0, 0.3}, {{1.5, 2.0}, {3.0, 1.0}}}})};
  survey.maps = {{.id = MapId("a"), .root = true}, {.id = MapId("b")}};
  const Pose2 door{1.5, 2.75, -M_PI / 2};
  survey.link_points = {Join("d1", AnchorAt("a", {}, door), AnchorAt("b", {1.0, 1.0, 0.3}, door))};
  EXPECT_TRUE(Arrange(survey).empty());
}

// Maps that are not bent: a door's anchors are as certain as the door.
rearrange::Rearrangement ArrangeStraight(const LevelSurvey& survey) {
  SurveyOptions options;
  options.bend = options.yaw_bend = 0.0;
  return ArrangeMaps(survey, Corridor(), options, NumberedIds());
}

// What a verdict at the door knew was little; the survey has seen both rooms as a whole.
TEST(ArrangeMaps, AnUnsureLinkPointBecomesAsSureAsTheSurvey) {
  LevelSurvey survey;
  survey.drives = {MakeDrive(
      {{"s1", "a", {}, {{9.0, 4.0}, {1.5, 4.0}, {1.5, 3.4}}}, {"s2", "b", {1.0, 1.0, 0.3}, {{1.5, 2.0}, {3.0, 1.0}}}})};
  survey.maps = {{.id = MapId("a"), .root = true}, {.id = MapId("b")}};
  const Pose2 door{1.5, 2.75, -M_PI / 2};
  survey.link_points = {Join("d1", AnchorAt("a", {}, door), AnchorAt("b", {1.0, 1.0, 0.3}, door))};
  survey.link_points[0].anchors[1].covariance(2, 2) = 0.04;  // 0.2 rad
  survey.variance_factor = 0.25;
  const rearrange::Rearrangement change = ArrangeStraight(survey);
  EXPECT_THAT(change.moves, IsEmpty());
  ASSERT_THAT(change.link_points, SizeIs(1));
  EXPECT_EQ(change.link_points[0].id, LinkPointId("d1"));
  const SurveyOptions options;
  for (const graph::Anchor& anchor : change.link_points[0].anchors) {
    EXPECT_NEAR(std::sqrt(anchor.covariance(0, 0)), 0.5 * options.door_sigma, 1e-9);
    EXPECT_NEAR(std::sqrt(anchor.covariance(2, 2)), 0.5 * options.door_yaw_sigma, 1e-9);
  }
  survey.link_points = change.link_points;
  survey.variance_factor = 0.2;  // as the drive goes on, little changes
  EXPECT_TRUE(ArrangeStraight(survey).empty());
  survey.variance_factor = 0.5;  // it was too sure
  EXPECT_THAT(ArrangeStraight(survey).link_points, SizeIs(1));
}

// Passages are no measurements of their own: what is off is how the map bends.
TEST(ArrangeMaps, ADoorThatRobotsWentThroughOftenIsNoMoreCertain) {
  LevelSurvey survey;
  std::vector<Eigen::Vector2d> way;
  for (int i = 0; i < 2; ++i) way.insert(way.end(), {{1.5, 4.5}, {1.5, 1.0}});  // three passages
  survey.drives = {MakeDrive({{"s", "a", {}, way}})};
  survey.maps = {{.id = MapId("a"), .root = true}};
  const rearrange::Rearrangement change = ArrangeStraight(survey);
  ASSERT_THAT(change.link_points, SizeIs(1));
  const SurveyOptions options;
  for (const graph::Anchor& anchor : change.link_points[0].anchors) {
    EXPECT_NEAR(anchor.covariance(0, 0), options.door_sigma * options.door_sigma, 1e-9);
    EXPECT_NEAR(anchor.covariance(2, 2), options.door_yaw_sigma * options.door_yaw_sigma, 1e-9);
  }
}

// The farther robots went in a map, the more it bends.
TEST(ArrangeMaps, DoorsOfALargeMapAreLessCertain) {
  LevelSurvey survey;
  survey.drives = {MakeDrive({{"s1", "a", {}, {{9.0, 4.0}, {1.5, 4.0}, {1.5, 3.4}}}, {"s2", "b", {}, {{1.5, 1.0}}}})};
  survey.maps = {{.id = MapId("a"), .root = true}, {.id = MapId("b")}};
  const rearrange::Rearrangement change = Arrange(survey);
  ASSERT_THAT(change.link_points, SizeIs(1));
  const SurveyOptions options;
  const graph::Anchor& large = *change.link_points[0].FindAnchor(MapId("a"));
  const graph::Anchor& small = *change.link_points[0].FindAnchor(MapId("b"));
  EXPECT_NEAR(std::sqrt(small.covariance(0, 0)), options.door_sigma, 1e-9);
  EXPECT_NEAR(std::sqrt(small.covariance(2, 2)), options.door_yaw_sigma, 1e-9);
  // Evenly along 7.5 m, and a little of the way to the door: 2.2 m and somewhat more.
  EXPECT_NEAR(std::sqrt(large.covariance(0, 0)), std::hypot(options.door_sigma, 2.35 * options.bend), 0.002);
  EXPECT_NEAR(std::sqrt(large.covariance(2, 2)), std::hypot(options.door_yaw_sigma, 2.35 * options.yaw_bend), 0.0005);
  EXPECT_GT(large.covariance(0, 0), 1.1 * small.covariance(0, 0));
}

TEST(ArrangeMaps, AnEmptyMapBehindTheLastDoorIsTheRoomThatTheDriveEndedIn) {
  LevelSurvey survey;
  survey.drives = {MakeDrive({{"s1", "a", {}, {{9.0, 4.0}, {1.5, 4.0}, {1.5, 1.0}}}})};
  survey.maps = {{.id = MapId("a"), .root = true}};
  const Pose2 robot{1.5, 1.2, -M_PI / 2};
  survey.awaited = {{MapId("empty"), robot, robot}};
  const Pose2 door{1.5, 2.75, -M_PI / 2};
  survey.link_points = {Join("d", AnchorAt("a", {}, door), AnchorAt("empty", robot, door))};
  const rearrange::Rearrangement change = Arrange(survey);
  EXPECT_TRUE(rearrange::Validate(change).ok());
  ASSERT_THAT(change.new_maps, SizeIs(1));
  const MapId room = change.new_maps[0].id;
  ASSERT_THAT(change.redirects, SizeIs(1));
  EXPECT_EQ(change.redirects[0].from, MapId("empty"));
  EXPECT_EQ(change.redirects[0].to, room);
  ASSERT_THAT(change.link_points, SizeIs(1));
  EXPECT_EQ(change.link_points[0].id, LinkPointId("d"));
  EXPECT_NE(change.link_points[0].FindAnchor(room), nullptr);
  LevelSurvey after = After(survey, change);
  after.awaited.clear();
  EXPECT_TRUE(Arrange(after).empty());
}

TEST(ArrangeMaps, AnEmptyMapInNoKnownRoomStays) {
  LevelSurvey survey;
  survey.drives = {MakeDrive({{"s1", "a", {}, {{9.0, 4.0}, {1.5, 4.0}}}})};
  survey.maps = {{.id = MapId("a"), .root = true}};
  const Pose2 robot{1.5, 1.2, -M_PI / 2};
  survey.awaited = {{MapId("empty"), robot, robot}};
  const Pose2 door{1.5, 2.75, -M_PI / 2};
  survey.link_points = {Join("d", AnchorAt("a", {}, door), AnchorAt("empty", robot, door))};
  EXPECT_TRUE(Arrange(survey).empty());
}

TEST(ArrangeMaps, ABusyMapStaysAndKeepsItsLinkPoints) {
  LevelSurvey survey = DoubledCorridor();
  survey.maps[2].busy = true;
  const rearrange::Rearrangement change = Arrange(survey);
  EXPECT_THAT(change.redirects, IsEmpty());
  for (const LinkPointId& removed : change.removed_link_points) EXPECT_NE(removed, LinkPointId("d2"));
}

// The pairs of link points of which one was changed, and makes the other redundant: the store would refuse the change.
std::vector<std::string> RedundantAfter(const LevelSurvey& survey, const rearrange::Rearrangement& change) {
  std::vector<std::string> pairs;
  const LevelSurvey after = After(survey, change);
  for (const graph::LinkPoint& changed : change.link_points) {
    for (const graph::LinkPoint& other : after.link_points) {
      if (other.id == changed.id || other.use == graph::LinkPointUse::kSuspended) continue;
      if (graph::FindCommonPlace(changed.anchors, other.anchors)) {
        pairs.push_back(changed.id.value() + " " + other.id.value());
      }
    }
  }
  return pairs;
}

// Two maps whose robots still record, and two link points at the door between them.
LevelSurvey BusyDoorJoinedTwice(const Pose2& T_level_second) {
  LevelSurvey survey;
  survey.drives = {MakeDrive(
      {{"s1", "a", {}, {{9.0, 4.0}, {1.5, 4.0}, {1.5, 3.4}}}, {"s2", "b", {1.0, 1.0, 0.3}, {{1.5, 2.0}, {3.0, 1.0}}}})};
  survey.maps = {{.id = MapId("a"), .root = true, .busy = true}, {.id = MapId("b"), .busy = true}};
  const Pose2 door{1.5, 2.75, -M_PI / 2};
  for (const auto& [id, place] : {std::pair("d1", door), std::pair("d2", T_level_second)}) {
    survey.link_points.push_back(Join(id, AnchorAt("a", {}, place), AnchorAt("b", {1.0, 1.0, 0.3}, place)));
  }
  return survey;
}

TEST(ArrangeMaps, ADoorJoinedTwiceKeepsOneLinkPoint) {
  LevelSurvey survey = BusyDoorJoinedTwice({1.6, 2.8, -M_PI / 2});
  survey.link_points[0].anchors[1].covariance(2, 2) = 0.04;  // the survey is surer, and changes it
  const rearrange::Rearrangement change = Arrange(survey);
  EXPECT_THAT(RedundantAfter(survey, change), IsEmpty());
  EXPECT_EQ(JoinedMaps(After(survey, change)), (std::multiset<std::set<std::string>>{{"a", "b"}}));
  EXPECT_TRUE(Arrange(After(survey, change)).empty());
}

// Its covariance says that it may be the door's, though it is farther away than a neighbouring door would be.
TEST(ArrangeMaps, AnUnsureLinkPointFarFromItsDoorIsThatDoors) {
  LevelSurvey survey = BusyDoorJoinedTwice({3.2, 2.8, -M_PI / 2});
  survey.link_points.erase(survey.link_points.begin());
  for (graph::Anchor& anchor : survey.link_points[0].anchors) anchor.covariance = Eigen::Matrix3d::Identity();
  const rearrange::Rearrangement change = Arrange(survey);
  ASSERT_THAT(change.link_points, SizeIs(1));
  EXPECT_EQ(change.link_points[0].id, LinkPointId("d2"));
  EXPECT_THAT(RedundantAfter(survey, change), IsEmpty());
  EXPECT_TRUE(Arrange(After(survey, change)).empty());
}

// Drives this uncertain cannot tell two doors apart that are side by side.
TEST(ArrangeMaps, DoorsThatTheDrivesCannotTellApartAreOne) {
  LevelSurvey survey;
  survey.drives = {MakeDrive(
      {{"s1", "a", {}, {{9.0, 4.0}, {1.2, 4.0}, {1.2, 1.0}}}, {"s2", "b", {}, {{1.2, 1.0}, {2.6, 1.0}, {2.6, 4.0}}}})};
  survey.maps = {{.id = MapId("a"), .root = true}, {.id = MapId("b")}};
  rooms::RoomPartition partition = Corridor();
  partition.doors = {{{0.8, 2.75}, {1.6, 2.75}, {1, 2}}, {{2.2, 2.75}, {3.0, 2.75}, {1, 2}}};
  const auto arrange = [&] { return ArrangeMaps(survey, partition, {}, NumberedIds()); };
  EXPECT_THAT(arrange().link_points, SizeIs(2));
  survey.variance_factor = 1000.0;
  const rearrange::Rearrangement change = arrange();
  EXPECT_THAT(change.link_points, SizeIs(1));
  EXPECT_THAT(RedundantAfter(survey, change), IsEmpty());
}

TEST(ArrangeMaps, AMapThatIsBusyElsewhereIsLeftInItsRoom) {
  LevelSurvey survey = DoubledCorridor();
  survey.maps[1].busy = true;  // the south room's
  const rearrange::Rearrangement change = Arrange(survey);
  ASSERT_THAT(change.redirects, SizeIs(1));
  EXPECT_EQ(change.redirects[0].from, MapId("c"));
}

TEST(ArrangeMaps, ACandidateAtAKnownDoorDisappearsAndOthersMoveWithTheirMap) {
  LevelSurvey survey = DoubledCorridor();
  graph::LinkPoint at_door;
  at_door.id = LinkPointId("seen");
  at_door.anchors = {AnchorAt("a", {}, {1.6, 4.5, -M_PI / 2})};
  graph::LinkPoint elsewhere;
  elsewhere.id = LinkPointId("other");
  elsewhere.anchors = {AnchorAt("c", kPlaceB, {8.0, 4.5, -M_PI / 2})};
  survey.link_points.push_back(at_door);
  survey.link_points.push_back(elsewhere);
  const LevelSurvey after = After(survey, Arrange(survey));
  const auto find = [&](const char* id) {
    for (const graph::LinkPoint& one : after.link_points) {
      if (one.id == LinkPointId(id)) return &one;
    }
    return static_cast<const graph::LinkPoint*>(nullptr);
  };
  EXPECT_EQ(find("seen"), nullptr);
  ASSERT_NE(find("other"), nullptr);
  ASSERT_NE(find("other")->FindAnchor(MapId("a")), nullptr);
  EXPECT_NEAR(find("other")->FindAnchor(MapId("a"))->T_map_place.x, 8.0, 1e-6);
}

TEST(ArrangeMaps, ACandidateBeforeOpenGroundDisappears) {
  LevelSurvey survey = DoubledCorridor();
  graph::LinkPoint along;
  along.id = LinkPointId("along the corridor");
  along.anchors = {AnchorAt("a", {}, {5.5, 4.2, 0.0})};
  graph::LinkPoint across;
  across.id = LinkPointId("at the wall");
  across.anchors = {AnchorAt("a", {}, {7.5, 4.2, M_PI / 2})};
  survey.link_points.push_back(along);
  survey.link_points.push_back(across);
  const rearrange::Rearrangement change = Arrange(survey);
  EXPECT_THAT(change.removed_link_points, ::testing::Contains(along.id));
  EXPECT_THAT(change.removed_link_points, ::testing::Not(::testing::Contains(across.id)));
  survey.gaps[across.id] = {{-0.2, 0.0, 0.0}, 0.9};  // in the corridor, not in the wall
  EXPECT_THAT(Arrange(survey).removed_link_points, ::testing::Contains(across.id));
}

TEST(ArrangeMaps, ACandidateThatWasSeenObliquelyDisappearsAtItsDoor) {
  LevelSurvey survey = DoubledCorridor();
  graph::LinkPoint oblique;
  oblique.id = LinkPointId("oblique");
  oblique.anchors = {AnchorAt("a", {}, {0.2, 4.4, -M_PI / 2})};
  graph::LinkPoint another;  // the north door, which no robot went through, is nearer to this robot's way
  another.id = LinkPointId("another");
  another.anchors = {AnchorAt("a", {}, {4.0, 3.2, 1.2})};
  survey.link_points.push_back(oblique);
  survey.link_points.push_back(another);
  const rearrange::Rearrangement change = Arrange(survey);
  EXPECT_THAT(change.removed_link_points, ::testing::Contains(oblique.id));
  EXPECT_THAT(change.removed_link_points, ::testing::Not(::testing::Contains(another.id)));
}

TEST(ArrangeMaps, ACandidateBelongsToTheRoomThatItWasSeenFrom) {
  LevelSurvey survey = DoubledCorridor();
  graph::LinkPoint seen;
  seen.id = LinkPointId("seen");
  seen.anchors = {AnchorAt("a", {}, {3.5, 1.0, 0.0})};  // in the south room, whose map is b
  survey.link_points.push_back(seen);
  const LevelSurvey after = After(survey, Arrange(survey));
  for (const graph::LinkPoint& one : after.link_points) {
    if (one.id != seen.id) continue;
    ASSERT_NE(one.FindAnchor(MapId("b")), nullptr);
    const Pose2 place = Pose2{1.0, 1.0, 0.3} * one.FindAnchor(MapId("b"))->T_map_place;
    EXPECT_NEAR(place.x, 3.5, 1e-6);
    EXPECT_NEAR(place.y, 1.0, 1e-6);
    return;
  }
  FAIL() << "the candidate is gone";
}

TEST(ArrangeMaps, ALiftToAnotherLevelIsKept) {
  LevelSurvey survey = DoubledCorridor();
  graph::LinkPoint lift =
      Join("lift", AnchorAt("c", kPlaceB, {8.0, 4.0, 0.0}), {MapId("upstairs"), {}, Eigen::Matrix3d::Identity()});
  lift.kind = graph::LinkPointKind::kLift;
  survey.link_points.push_back(lift);
  const LevelSurvey after = After(survey, Arrange(survey));
  const auto found = std::find_if(after.link_points.begin(), after.link_points.end(),
                                  [](const graph::LinkPoint& one) { return one.id == LinkPointId("lift"); });
  ASSERT_NE(found, after.link_points.end());
  ASSERT_NE(found->FindAnchor(MapId("a")), nullptr);
  EXPECT_NEAR(found->FindAnchor(MapId("a"))->T_map_place.x, 8.0, 1e-6);
  EXPECT_EQ(found->FindAnchor(MapId("upstairs"))->T_map_place, Pose2{});
}

TEST(ArrangeMaps, ALinkPointWhereNoDoorIsDisappears) {
  LevelSurvey survey = DoubledCorridor();
  const Pose2 nowhere{7.0, 4.0, 0.0};
  survey.link_points.push_back(Join("false", AnchorAt("a", {}, nowhere), AnchorAt("c", kPlaceB, nowhere)));
  const rearrange::Rearrangement change = Arrange(survey);
  EXPECT_THAT(change.removed_link_points, ::testing::Contains(LinkPointId("false")));
}

}  // namespace
}  // namespace enfilade::survey
