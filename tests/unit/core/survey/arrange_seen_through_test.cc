// SPDX-License-Identifier: Apache-2.0
// Link points at doors that robots have seen from both sides and did not drive through.
#include "core/survey/arrange_maps.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/unit/core/survey/drawn_level.h"

namespace enfilade::survey {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

const Pose2 kRoomFrame{4.0, 7.0, 0.4};
const Pose2 kDoor{5.0, 5.25, M_PI_2};  // from the corridor into the north room

// A robot in the corridor, another one in the north room.
LevelSurvey OnBothSides() {
  LevelSurvey survey;
  survey.drives = {MakeDrive({{"s", "a", {}, {{1.5, 4.0}, {9.0, 4.0}, {5.0, 4.0}}}}),
                   MakeDrive({{"t", "b", kRoomFrame, {{3.5, 6.0}, {5.5, 6.0}, {5.5, 7.0}, {3.5, 7.0}}}})};
  survey.maps = {{.id = MapId("a"), .root = true}, {.id = MapId("b")}};
  survey.link_points = {Join("seen", AnchorAt("a", {}, kDoor), AnchorAt("b", kRoomFrame, kDoor))};
  return survey;
}

TEST(ArrangeSeenThrough, ADoorThatRobotsSawThroughKeepsItsLinkPoint) {
  LevelSurvey survey = OnBothSides();
  EXPECT_THAT(Arrange(survey).removed_link_points, ElementsAre(LinkPointId("seen"))) << "nobody went through";
  survey.seen_through = {LinkPointId("seen")};
  EXPECT_TRUE(Arrange(survey).empty());
}

TEST(ArrangeSeenThrough, ItIsTheLinkPointOfTheRobotThatGoesThroughLater) {
  LevelSurvey survey = OnBothSides();
  survey.seen_through = {LinkPointId("seen")};
  survey.drives.push_back(MakeDrive({{"u", "a", {}, {{1.5, 4.0}, {5.0, 4.0}, {5.0, 5.5}}, 1},
                                     {"v", "b", kRoomFrame, {{5.0, 6.0}, {5.0, 7.0}, {3.5, 7.0}}}}));
  const rearrange::Rearrangement change = Arrange(survey);
  EXPECT_THAT(change.removed_link_points, IsEmpty());
  const LevelSurvey after = After(survey, change);
  ASSERT_EQ(after.link_points.size(), 1U) << "not a second one";
  EXPECT_EQ(after.link_points[0].id, LinkPointId("seen"));
}

// A drive through corridor and south room had one map; the corridor's part gets another one.
TEST(ArrangeSeenThrough, ItGoesWithTheRoomBeforeTheDoor) {
  LevelSurvey survey = OnBothSides();
  survey.seen_through = {LinkPointId("seen")};
  survey.drives[0] = MakeDrive({{"s",
                                 "a",
                                 {},
                                 {{9.0, 4.0},
                                  {1.5, 4.0},
                                  {1.5, 1.0},
                                  {3.5, 0.5},
                                  {1.5, 0.5},
                                  {3.5, 1.5},
                                  {1.5, 1.5},
                                  {3.5, 2.0},
                                  {0.5, 2.0},
                                  {3.5, 0.5},
                                  {0.5, 0.5}}}});
  LevelSurvey after = survey;
  for (int i = 0; i < 5; ++i) {
    const rearrange::Rearrangement change = Arrange(after);
    if (change.empty()) break;
    after = After(after, change);
  }
  const std::set<std::string> corridor = MapsOfRooms(after, Corridor()).at(1);
  ASSERT_EQ(corridor.size(), 1U);
  EXPECT_NE(*corridor.begin(), "a") << "the south room keeps it: the robot drove farther there";
  EXPECT_EQ(JoinedMaps(after).count({*corridor.begin(), "b"}), 1U);
}

}  // namespace
}  // namespace enfilade::survey
