// SPDX-License-Identifier: Apache-2.0
#include "server/app/survey/stored_drives.h"

#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace enfilade::server {
namespace {

storage::Session MappedSession(const std::string& id, const std::string& previous) {
  storage::Session session;
  session.id = SessionId(id);
  session.robot = RobotId("robot");
  session.map = MapId("m");
  session.state = storage::SessionState::kMapped;
  if (!previous.empty()) session.entry.previous = SessionId(previous);
  return session;
}

std::map<MapId, storage::Map> Maps() {
  storage::Map ground;
  ground.id = MapId("m");
  storage::Map above;
  above.id = MapId("above");
  above.level = 1;
  return {{ground.id, ground}, {above.id, above}};
}

// The sessions' ids, drives parted by bars.
std::string Names(const std::vector<StoredDrive>& drives) {
  std::string names;
  for (const StoredDrive& drive : drives) {
    names += names.empty() ? "" : "|";
    for (const storage::Session* session : drive) names += session->id.value();
  }
  return names;
}

TEST(DrivesOn, FollowsTheChainWhateverTheOrder) {
  const std::vector<storage::Session> sessions{MappedSession("a", ""), MappedSession("c", "b"), MappedSession("b", "a"),
                                               MappedSession("d", "c")};
  EXPECT_EQ(Names(DrivesOn(0, sessions, Maps())), "abcd");
}

TEST(DrivesOn, OfTwoThatFollowOneTheFirstContinues) {
  const std::vector<storage::Session> sessions{MappedSession("a", ""), MappedSession("b", "a"), MappedSession("c", "a"),
                                               MappedSession("d", "c")};
  EXPECT_EQ(Names(DrivesOn(0, sessions, Maps())), "ab|cd");
}

TEST(DrivesOn, EndsWhereASessionIsMissing) {
  std::vector<storage::Session> sessions{MappedSession("a", ""), MappedSession("b", "a"), MappedSession("c", "b"),
                                         MappedSession("d", "c")};
  sessions[1].state = storage::SessionState::kFinished;
  EXPECT_EQ(Names(DrivesOn(0, sessions, Maps())), "a|cd");
  sessions[1] = MappedSession("b", "a");
  sessions[1].records_deleted = true;
  EXPECT_EQ(Names(DrivesOn(0, sessions, Maps())), "a|cd");
  sessions[1] = MappedSession("b", "a");
  sessions[1].map.reset();
  EXPECT_EQ(Names(DrivesOn(0, sessions, Maps())), "a|cd");
}

TEST(DrivesOn, EndsBeforeASessionWhoseDoorsAreNotJudged) {
  std::vector<storage::Session> sessions{MappedSession("a", ""), MappedSession("b", "a")};
  sessions[1].record_counts.door_reports = 1;
  EXPECT_EQ(Names(DrivesOn(0, sessions, Maps())), "a");
  EXPECT_TRUE(IsUnderWay(sessions[1]));
  sessions[1].doors_judged = true;
  EXPECT_EQ(Names(DrivesOn(0, sessions, Maps())), "ab");
  EXPECT_FALSE(IsUnderWay(sessions[1]));
}

TEST(DrivesOn, IsOfOneLevel) {
  std::vector<storage::Session> sessions{MappedSession("a", ""), MappedSession("b", "a"), MappedSession("c", "b")};
  sessions[1].map = MapId("above");
  EXPECT_EQ(Names(DrivesOn(0, sessions, Maps())), "a|c");
  EXPECT_EQ(Names(DrivesOn(1, sessions, Maps())), "b");
  EXPECT_TRUE(DrivesOn(2, sessions, Maps()).empty());
}

TEST(KeyOf, IsOfTheRecordsNotOfTheSessions) {
  storage::Session whole = MappedSession("a", "");
  whole.record_counts.laser_scans = 10;
  whole.record_counts.odometry = 30;
  whole.payload_bytes = 500;
  whole.first_time = 100;
  whole.last_time = 900;
  storage::Session first = whole;
  first.record_counts.laser_scans = 4;
  first.record_counts.odometry = 20;
  first.payload_bytes = 300;
  first.last_time = 500;
  storage::Session rest = MappedSession("b", "a");
  rest.record_counts.laser_scans = 6;
  rest.record_counts.odometry = 10;
  rest.payload_bytes = 200;
  rest.first_time = 501;
  rest.last_time = 900;
  const std::string key = KeyOf({&whole}, Environment::kIndoor);
  EXPECT_EQ(KeyOf({&first, &rest}, Environment::kIndoor), key);
  EXPECT_NE(KeyOf({&first}, Environment::kIndoor), key);
  EXPECT_NE(KeyOf({&whole}, Environment::kOutdoor), key);
  whole.robot = RobotId("another");
  EXPECT_NE(KeyOf({&whole}, Environment::kIndoor), key);
}

TEST(CountSessionsOf, FindsTheDriveAsItWasBeforeItWentOn) {
  storage::Session first = MappedSession("a", "");
  first.record_counts.laser_scans = 4;
  first.payload_bytes = 300;
  first.first_time = 100;
  first.last_time = 500;
  storage::Session second = MappedSession("b", "a");
  second.record_counts.laser_scans = 6;
  second.payload_bytes = 200;
  second.first_time = 501;
  second.last_time = 900;
  const Environment indoor = Environment::kIndoor;
  EXPECT_EQ(CountSessionsOf(KeyOf({&first}, indoor), {&first, &second}, indoor), 1);
  EXPECT_EQ(CountSessionsOf(KeyOf({&first, &second}, indoor), {&first, &second}, indoor), 2);
  EXPECT_EQ(BeginningOf({&first}, indoor), BeginningOf({&first, &second}, indoor));
  // The first session was cut since.
  storage::Session rest = second;
  rest.id = SessionId("rest");
  storage::Session head = first;
  head.record_counts.laser_scans = 1;
  head.payload_bytes = 100;
  head.last_time = 200;
  rest.record_counts.laser_scans = 3;
  rest.payload_bytes = 200;
  rest.first_time = 201;
  rest.last_time = 500;
  EXPECT_EQ(CountSessionsOf(KeyOf({&first}, indoor), {&head, &rest, &second}, indoor), 2);
  EXPECT_EQ(CountSessionsOf(KeyOf({&second}, indoor), {&first, &second}, indoor), 0);
  EXPECT_EQ(CountSessionsOf(KeyOf({&first}, indoor), {&first, &second}, Environment::kOutdoor), 0);
}

}  // namespace
}  // namespace enfilade::server
