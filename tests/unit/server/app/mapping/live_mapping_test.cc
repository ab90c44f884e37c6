// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "tests/unit/server/app/mapping/mapping_workers.h"

namespace enfilade::server {
namespace {

using State = storage::SessionState;

TEST_F(MappingWorkersTest, ALiveSessionIsMappedAsItsRecordsComeAndLoadedOnce) {
  const SessionId session = NewSession("s");
  options_.checkpoint_interval_s = 0.0;
  Start();
  for (std::size_t begin = 0; begin < Log().size(); begin += 67) {
    const std::size_t end = std::min(Log().size(), begin + 67);
    Append(session, begin, end);
    mapping_->Wake();
    AwaitMapped(session, static_cast<std::int64_t>(end));
  }
  Finish(session);
  mapping_->Wake();
  AwaitState(session, State::kMapped);
  ExpectOfflineMap(session);
  EXPECT_EQ(counting_.loads(), 1) << "kept between its turns";
}

// A checkpoint takes about as long to write as a scan to map.
TEST_F(MappingWorkersTest, ALiveSessionIsStoredOnceACheckpointIsDue) {
  const SessionId session = StartWithLiveSession(1.0);
  while (counting_.read_sequence() < 40) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  const TimeNs first_pose = stores_.robot_poses.Get(Soon(), site_, RobotId("r"))->time;
  const auto begin = std::chrono::steady_clock::now();
  const int commits = counting_.commits();
  for (std::size_t end = 42; end <= 80; end += 2) {
    Append(session, end - 2, end);
    mapping_->Wake(site_, session);
    std::this_thread::sleep_for(std::chrono::milliseconds(120));  // more than a worker rests between two looks
  }
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  EXPECT_LE(counting_.commits() - commits, took.count() / options_.checkpoint_interval_s + 1.0);
  EXPECT_GT(stores_.robot_poses.Get(Soon(), site_, RobotId("r"))->time, first_pose) << "the pose is, at each turn";
  AwaitMapped(session, 80);  // though the robot sends nothing more
  EXPECT_EQ(counting_.loads(), 1);
  Append(session, 80, Log().size());
  Finish(session);
  mapping_->Wake();
  AwaitState(session, State::kMapped);
  ExpectOfflineMap(session);
}

TEST_F(MappingWorkersTest, AServerThatStopsLeavesWhatItHasNotStoredToTheNextOne) {
  const SessionId session = StartWithLiveSession(3600.0);
  Append(session, 40, 80);
  mapping_->Wake(site_, session);
  while (counting_.read_sequence() < 80) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_EQ(Session(session).mapped_sequence, 40) << "not due for an hour";
  mapping_.reset();
  Start();
  AwaitMapped(session, 80);
}

// Seven live sessions, whose records come in five portions.
class ManyLiveSessionsTest : public MappingWorkersTest {
 protected:
  void MapThem() {
    options_.checkpoint_interval_s = 0.5;
    for (int i = 0; i < kSessions; ++i) {
      const std::string id = std::to_string(i);
      ASSERT_OK(stores_.maps.Create(Soon(), MakeMap(site_, "room" + id), ""));
      sessions_.push_back(NewSession("s" + id, "room" + id));
    }
    Start(2);
    for (std::size_t end = 20; end <= 100; end += 20) {
      for (const SessionId& session : sessions_) {
        Append(session, end - 20, end);
        mapping_->Wake(site_, session);
      }
      for (const SessionId& session : sessions_) AwaitMapped(session, static_cast<std::int64_t>(end));
    }
  }

  static constexpr int kSessions = 7;
  std::vector<SessionId> sessions_;
};

TEST_F(ManyLiveSessionsTest, AreLoadedOnceIfThereIsRoom) {
  MapThem();
  EXPECT_EQ(counting_.loads(), kSessions);
}

TEST_F(ManyLiveSessionsTest, AreStoredAndLoadedAgainIfThereIsNone) {
  options_.parked_bytes = 1;
  MapThem();
  EXPECT_GT(counting_.loads(), 2 * kSessions);
  for (const SessionId& session : sessions_) Finish(session);
  mapping_->Wake();
  for (const SessionId& session : sessions_) AwaitState(session, State::kMapped);
}

}  // namespace
}  // namespace enfilade::server
