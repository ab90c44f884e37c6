// SPDX-License-Identifier: Apache-2.0
// What the fakes offer beside the stores' contracts: tests/contract/storage has those.
#include <gmock/gmock.h>

#include <chrono>
#include <thread>

#include "tests/fakes/in_memory_stores.h"
#include "tests/support/status_assertions.h"

namespace enfilade::testing {
namespace {

using std::chrono::milliseconds;
using std::chrono::minutes;
using std::chrono::seconds;
using ::testing::SizeIs;

class FakesTest : public ::testing::Test {
 protected:
  FakesTest() {
    stores_.database.AddSite(site_);
    stores_.database.AddRobot(site_, RobotId("r1"));
    storage::Map map;
    map.site = site_;
    map.id = MapId("hall");
    map.display_name = "Hall";
    EXPECT_OK(stores_.maps.Create(Soon(), map, ""));
    storage::Session session;
    session.site = site_;
    session.id = SessionId("s1");
    session.robot = RobotId("r1");
    session.map = map.id;
    EXPECT_OK(stores_.sessions.Create(Soon(), session, ""));
  }
  static storage::CallContext Soon() { return storage::CallContext::WithTimeout(seconds(60)); }

  const SiteId site_{"campus"};
  InMemoryStores stores_;
};

TEST_F(FakesTest, EveryCallFailsWhileTheDatabaseIsAway) {
  ASSERT_OK_AND_ASSIGN(const auto listener, stores_.graphs.Listen(Soon()));
  stores_.database.FailCalls(absl::UnavailableError("away"));
  EXPECT_CODE(stores_.maps.Get(Soon(), site_, MapId("hall")), absl::StatusCode::kUnavailable);
  EXPECT_CODE(stores_.sessions.Delete(Soon(), site_, SessionId("s1")), absl::StatusCode::kUnavailable);
  EXPECT_CODE(stores_.records.Append(Soon(), {site_, SessionId("s1"), {}, {}}), absl::StatusCode::kUnavailable);
  EXPECT_CODE(stores_.graphs.Listen(Soon()), absl::StatusCode::kUnavailable);
  EXPECT_CODE(listener->Await(Soon()), absl::StatusCode::kUnavailable);
  stores_.database.FailCalls(absl::OkStatus());
  EXPECT_OK(stores_.sessions.Get(Soon(), site_, SessionId("s1")));
}

TEST_F(FakesTest, AListenerThatWaitsLearnsOfTheFailure) {
  ASSERT_OK_AND_ASSIGN(const auto listener, stores_.graphs.Listen(Soon()));
  std::thread outage([&] {
    std::this_thread::sleep_for(milliseconds(20));
    stores_.database.FailCalls(absl::UnavailableError("away"));
  });
  EXPECT_CODE(listener->Await(Soon()), absl::StatusCode::kUnavailable);
  outage.join();
}

TEST_F(FakesTest, ACancelledCallDoesNothing) {
  std::stop_source source;
  storage::CallContext context = Soon();
  context.cancellation = source.get_token();
  EXPECT_OK(stores_.sessions.Get(context, site_, SessionId("s1")));
  source.request_stop();
  EXPECT_CODE(stores_.sessions.Delete(context, site_, SessionId("s1")), absl::StatusCode::kCancelled);
  EXPECT_OK(stores_.sessions.Get(Soon(), site_, SessionId("s1")));
}

TEST_F(FakesTest, TheClockLetsLeasesExpireWithoutWaiting) {
  ASSERT_OK_AND_ASSIGN(const auto first, stores_.site_leases.Acquire(Soon(), site_, "first", minutes(5)));
  ASSERT_TRUE(first);
  stores_.database.AdvanceClock(minutes(4));
  ASSERT_OK_AND_ASSIGN(const auto early, stores_.site_leases.Acquire(Soon(), site_, "second", minutes(5)));
  EXPECT_FALSE(early);
  ASSERT_OK(stores_.site_leases.Renew(Soon(), *first, minutes(5)));
  stores_.database.AdvanceClock(minutes(4));
  ASSERT_OK_AND_ASSIGN(const auto renewed, stores_.site_leases.Acquire(Soon(), site_, "second", minutes(5)));
  EXPECT_FALSE(renewed);
  stores_.database.AdvanceClock(minutes(2));
  ASSERT_OK_AND_ASSIGN(const auto second, stores_.site_leases.Acquire(Soon(), site_, "second", minutes(5)));
  ASSERT_TRUE(second);
  EXPECT_EQ(second->token, first->token + 1);
}

TEST_F(FakesTest, StoresOfOneDatabaseSeeTheSame) {
  const InMemoryMapStore others_maps(stores_.database);
  ASSERT_OK_AND_ASSIGN(const auto maps, others_maps.List(Soon(), site_, {}));
  EXPECT_THAT(maps, SizeIs(1));
  InMemoryStores elsewhere;
  EXPECT_CODE(elsewhere.maps.Get(Soon(), site_, MapId("hall")), absl::StatusCode::kNotFound);
}

TEST_F(FakesTest, CreationTimesIncreaseWithEveryRow) {
  TimeNs last = 0;
  for (int i = 0; i < 100; ++i) {
    storage::Map map;
    map.site = site_;
    map.id = MapId("m" + std::to_string(i));
    map.display_name = map.id.value();
    ASSERT_OK_AND_ASSIGN(const storage::Map created, stores_.maps.Create(Soon(), map, ""));
    EXPECT_GT(created.create_time, last);
    last = created.create_time;
  }
}

}  // namespace
}  // namespace enfilade::testing
