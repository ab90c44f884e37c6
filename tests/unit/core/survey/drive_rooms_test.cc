// SPDX-License-Identifier: Apache-2.0
#include "core/survey/drive_rooms.h"

#include "gtest/gtest.h"
#include "tests/unit/core/survey/drawn_level.h"

namespace enfilade::survey {
namespace {

std::vector<int> RoomsInOrder(const RoomsOfDrives& found) {
  std::vector<int> rooms;
  for (const Stretch& stretch : found.stretches) {
    if (rooms.empty() || rooms.back() != stretch.room) rooms.push_back(stretch.room);
  }
  return rooms;
}

TEST(FindRooms, ADriveThroughTwoDoorsIsInThreeRooms) {
  LevelSurvey survey;
  survey.drives = {MakeDrive({{"s", "m", {}, {{1.5, 1.0}, {1.5, 4.0}, {5.0, 4.0}, {5.0, 6.5}}}})};
  const RoomsOfDrives found = FindRooms(survey, Corridor(), {});
  EXPECT_EQ(RoomsInOrder(found), (std::vector<int>{2, 1, 3}));
  ASSERT_EQ(found.crossings.size(), 2u);
  EXPECT_EQ(found.crossings[0].from, 2);
  EXPECT_EQ(found.crossings[0].to, 1);
  EXPECT_NEAR(found.crossings[0].T_level_before.y, 2.75, 0.5);
}

TEST(FindRooms, ALookIntoARoomIsNoVisit) {
  LevelSurvey survey;
  survey.drives = {MakeDrive({{"s", "m", {}, {{5.0, 4.0}, {5.0, 5.6}, {5.0, 4.0}, {8.0, 4.0}}}})};
  const RoomsOfDrives found = FindRooms(survey, Corridor(), {});
  EXPECT_EQ(RoomsInOrder(found), (std::vector<int>{1}));
  EXPECT_TRUE(found.crossings.empty());
}

TEST(FindRooms, AStretchMayBeginInOneSessionAndEndInTheNext) {
  LevelSurvey survey;  // 0.3 m of the room in each session: together a visit
  survey.drives = {MakeDrive({{"a", "m", {}, {{5.0, 4.0}, {5.0, 5.8}}}, {"b", "n", {}, {{5.0, 5.8}, {5.0, 6.1}}}})};
  EXPECT_EQ(RoomsInOrder(FindRooms(survey, Corridor(), {})), (std::vector<int>{1, 3}));
}

TEST(FindRooms, TheEndOfASessionBehindTheDoorThatItReportsIsInTheNextRoom) {
  std::vector<Leg> legs = {{"a", "m", {}, {{1.5, 1.0}, {1.5, 4.0}}}, {"b", "n", {}, {{1.5, 4.0}, {8.0, 4.0}}}};
  legs[0].left = 7 * TimeNs{500'000'000};  // at y 2.5
  LevelSurvey survey;
  survey.drives = {MakeDrive(legs)};
  const RoomsOfDrives found = FindRooms(survey, Corridor(), {});
  ASSERT_EQ(found.stretches.size(), 3u);
  EXPECT_EQ(found.stretches[0].session, 0u);
  EXPECT_EQ(found.stretches[1].session, 0u);
  EXPECT_NE(found.stretches[1].room, found.stretches[0].room);
  EXPECT_EQ(found.stretches[1].room, found.stretches[2].room);
}

TEST(FindRooms, ADriveInNoRoomIsLeftOut) {
  LevelSurvey survey;
  survey.drives = {MakeDrive({{"s", "m", {}, {{8.0, 1.0}, {9.0, 1.0}}}})};
  EXPECT_TRUE(FindRooms(survey, Corridor(), {}).stretches.empty());
}

TEST(FindRooms, WithoutDrivesThereIsNothing) { EXPECT_TRUE(FindRooms({}, Corridor(), {}).stretches.empty()); }

}  // namespace
}  // namespace enfilade::survey
