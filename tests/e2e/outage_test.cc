// SPDX-License-Identifier: Apache-2.0
// What robots and people see while a server ends, while database or server are down, and when another server takes
// over.
#include <gtest/gtest.h>
#include <signal.h>

#include <thread>

#include "enfilade/v1/ingest_service.grpc.pb.h"
#include "enfilade/v1/site_service.grpc.pb.h"
#include "tests/e2e/whole_system.h"

namespace enfilade::testing {
namespace {

const std::vector<std::string> kSettings = {"mapping.lease_s=1", "listen.grace_s=5"};

class OutageTest : public ::testing::Test {
 protected:
  OutageTest() : system_(kSettings) { Prepare(); }
  explicit OutageTest(Cluster::Durability durability) : system_(durability, kSettings) { Prepare(); }

  absl::Status ListSites() const {
    return system_.server().Connect().Call(&v1::SiteService::Stub::ListSites, v1::ListSitesRequest()).status();
  }
  // Waits until the robot has added to its spool.
  bool SpoolGrows(const Replay& replay) const {
    const std::int64_t before = system_.SpooledSequence(replay);
    return Eventually([&] { return system_.SpooledSequence(replay) > before; });
  }

  mutable WholeSystem system_;

 private:
  void Prepare() {
    system_.RecordDrive(2);
    system_.CreateSite("s");
  }
};

class DatabaseOutageTest : public OutageTest {
 protected:
  DatabaseOutageTest() : OutageTest(Cluster::Durability::kFast) {}
};

TEST_F(OutageTest, SigtermAnswersOpenStreamsAndEndsInTime) {
  const Replay replay{.site = "s", .rate = "4"};
  const auto robot = system_.StartReplay(replay, system_.server());
  ASSERT_TRUE(Eventually([&] { return system_.AcknowledgedSequence("s") > 0; })) << TailOf(system_.ReplayLog(replay));
  // A second stream, idle.
  const client::Connection connection = system_.server().Connect();
  const auto stub = v1::IngestService::NewStub(connection.channel());
  grpc::ClientContext context;
  const auto stream = stub->StreamRecords(&context);
  v1::StreamRecordsRequest open;
  open.mutable_open()->set_session("sites/s/sessions/drive");
  ASSERT_TRUE(stream->Write(open));
  v1::StreamRecordsResponse response;
  ASSERT_TRUE(stream->Read(&response));
  ASSERT_TRUE(response.has_opened());

  system_.server().process().Signal(SIGTERM);
  while (stream->Read(&response)) {
  }
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_EQ(system_.server().process().Wait(std::chrono::seconds(60)), 0) << TailOf(system_.server().log());
  EXPECT_EQ(HealthOf(connection), Health::kUnreachable);

  // The robot has lost nothing and continues with the next server.
  const std::int64_t acknowledged = system_.AcknowledgedSequence("s");
  ASSERT_TRUE(robot->running());
  system_.server().StartAndWait();
  EXPECT_TRUE(Eventually([&] { return system_.AcknowledgedSequence("s") > acknowledged; }));
}

TEST_F(DatabaseOutageTest, WithoutDatabaseTheServerIsNotReadyAndRobotsSpoolOn) {
  const Replay replay{.site = "s", .rate = "10"};
  const auto robot = system_.StartReplay(replay, system_.server());
  ASSERT_TRUE(Eventually([&] { return system_.AcknowledgedSequence("s") > 0; })) << TailOf(system_.ReplayLog(replay));
  system_.KillDatabase();
  const client::Connection connection = system_.server().Connect();
  EXPECT_TRUE(Eventually([&] { return HealthOf(connection) == Health::kNotServing; }));
  EXPECT_EQ(ListSites().code(), absl::StatusCode::kUnavailable) << ListSites();
  EXPECT_TRUE(SpoolGrows(replay));
  EXPECT_TRUE(robot->running());

  system_.RestartDatabase();
  EXPECT_TRUE(Eventually([&] { return HealthOf(connection) == Health::kServing; }));
  EXPECT_EQ(ListSites(), absl::OkStatus());
  EXPECT_EQ(robot->Wait(std::chrono::minutes(5)), 0) << TailOf(system_.ReplayLog(replay));
}

TEST_F(OutageTest, RobotsSpoolOnWhileNoServerIsThere) {
  system_.server().Kill();
  const Replay replay{.site = "s", .rate = "10"};
  const auto robot = system_.StartReplay(replay, system_.server());
  EXPECT_TRUE(Eventually([&] { return system_.SpooledSequence(replay) > 0; })) << TailOf(system_.ReplayLog(replay));
  EXPECT_TRUE(SpoolGrows(replay));
  EXPECT_EQ(system_.AcknowledgedSequence("s"), 0);
  system_.server().StartAndWait();
  EXPECT_EQ(robot->Wait(std::chrono::minutes(5)), 0) << TailOf(system_.ReplayLog(replay));
}

TEST_F(OutageTest, AnotherServerTakesOverTheMappingOfAKilledOne) {
  const Replay replay{.site = "s", .wait = false};
  const auto robot = system_.StartReplay(replay, system_.server());
  // Killed while it holds the lease. It is stopped first, so that it cannot release the lease between check and kill.
  const auto holds_lease = [&] {
    const auto held = system_.TryQuery("SELECT token FROM session_leases WHERE expires_at > now()");
    return held && !held->empty();
  };
  ASSERT_TRUE(Eventually([&] {
    if (!holds_lease()) return false;
    system_.server().process().Signal(SIGSTOP);
    if (holds_lease()) return true;
    system_.server().process().Signal(SIGCONT);
    return false;
  }));
  const std::string first = system_.Query("SELECT owner FROM session_leases");
  const std::int64_t token = std::stoll(system_.Query("SELECT token FROM session_leases"));
  system_.server().Kill();
  robot->Kill();

  const auto second = system_.AnotherServer("second");
  second->StartAndWait();
  const Replay rest{.site = "s"};
  const auto same_robot = system_.StartReplay(rest, *second);
  EXPECT_EQ(same_robot->Wait(std::chrono::minutes(5)), 0) << TailOf(system_.ReplayLog(rest)) << TailOf(second->log());
  EXPECT_EQ(system_.Query("SELECT state FROM sessions"), "3");  // mapped
  EXPECT_NE(system_.Query("SELECT owner FROM session_leases"), first);
  EXPECT_GT(std::stoll(system_.Query("SELECT token FROM session_leases")), token);
  EXPECT_EQ(system_.Query("SELECT token FROM mapping_checkpoints"), system_.Query("SELECT token FROM session_leases"));
}

}  // namespace
}  // namespace enfilade::testing
