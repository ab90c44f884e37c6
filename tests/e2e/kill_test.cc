// SPDX-License-Identifier: Apache-2.0
// Server, robot and database are killed (kill -9) at random moments of a drive. In the end the stored records and the
// map must equal those of an undisturbed drive.
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <random>
#include <thread>

#include "tests/e2e/whole_system.h"

namespace enfilade::testing {
namespace {

enum class Victim { kServer, kRobot, kDatabase, kDatabaseBackend };

constexpr int kLaps = 6;
constexpr char kPace[] = "1.5";  // times the recorded speed: slow enough to outlast the kills
constexpr int kKillsOfEach = 5;  // of a backend and of the whole database; server and robot twice as often

std::vector<Victim> VictimsInRandomOrder(std::mt19937_64& random) {
  std::vector<Victim> victims;
  for (int i = 0; i < kKillsOfEach; ++i) {
    victims.insert(victims.end(), {Victim::kServer, Victim::kServer, Victim::kRobot, Victim::kRobot, Victim::kDatabase,
                                   Victim::kDatabaseBackend});
  }
  std::shuffle(victims.begin(), victims.end(), random);
  return victims;
}

// A robot that has failed many times in a row waits for half a minute before the next attempt.
constexpr auto kPatience = std::chrono::seconds(300 * kSlowdown);

class KillTest : public ::testing::Test {
 protected:
  KillTest()
      : system_(Cluster::Durability::kDurable, {"mapping.lease_s=1", "mapping.checkpoint_interval_s=0.2",
                                                "mapping.revision_interval_s=1", "listen.grace_s=2"}) {
    const char* seed = std::getenv("ENFILADE_KILL_SEED");
    const std::uint64_t value = seed ? std::strtoull(seed, nullptr, 10) : 20261121;
    RecordProperty("seed", std::to_string(value));
    std::cout << "seed " << value << " (set ENFILADE_KILL_SEED for another)" << std::endl;
    random_.seed(value);
  }

  std::chrono::milliseconds RandomTime(int max_ms) {
    return std::chrono::milliseconds(std::uniform_int_distribution<int>(0, max_ms)(random_));
  }
  // Neither robot nor server ends on its own, whatever happens to the others.
  void ExpectAllAlive() {
    ASSERT_TRUE(robot_->running()) << TailOf(system_.ReplayLog(storm_));
    ASSERT_TRUE(system_.server().process().running()) << TailOf(system_.server().log());
  }
  void KillAndRestart(Victim victim);
  void KillBackend();

  WholeSystem system_;
  std::mt19937_64 random_;
  Replay storm_{.site = "storm", .rate = kPace};
  std::unique_ptr<Process> robot_;
};

void KillTest::KillBackend() {
  const auto backends = system_.TryQuery(
      "SELECT pid FROM pg_stat_activity WHERE backend_type = 'client backend' AND application_name LIKE 'enfilade%'"
      " AND pid <> pg_backend_pid() ORDER BY pid");
  if (!backends || backends->empty()) {
    system_.KillDatabase();  // it is recovering: kill the whole database instead
    system_.cluster().Restart();
    return;
  }
  const std::size_t which = std::uniform_int_distribution<std::size_t>(0, backends->size() - 1)(random_);
  kill(std::stoi((*backends)[which]), SIGKILL);  // the postmaster ends all others and recovers
}

// What was killed restarts immediately or a moment later. The next kill may come while it is still starting.
void KillTest::KillAndRestart(Victim victim) {
  switch (victim) {
    case Victim::kServer:
      system_.server().Kill();
      std::this_thread::sleep_for(RandomTime(300));
      system_.server().Start();
      break;
    case Victim::kRobot:
      robot_->Kill();
      std::this_thread::sleep_for(RandomTime(300));
      robot_ = system_.StartReplay(storm_, system_.server());
      break;
    case Victim::kDatabase:
      system_.KillDatabase();
      std::this_thread::sleep_for(RandomTime(300));
      system_.cluster().Restart();
      break;
    case Victim::kDatabaseBackend:
      KillBackend();
      break;
  }
}

TEST_F(KillTest, NothingIsLostOrDoubledAndTheMapIsTheSame) {
  ASSERT_EQ(system_.Query("SHOW fsync"), "on");
  ASSERT_EQ(system_.Query("SHOW synchronous_commit"), "on");
  system_.RecordDrive(kLaps);

  const Replay calm{.site = "calm"};
  system_.CreateSite(calm.site);
  robot_ = system_.StartReplay(calm, system_.server());
  ASSERT_EQ(robot_->Wait(std::chrono::minutes(10)), 0) << TailOf(system_.ReplayLog(calm));
  const std::int64_t records = system_.AcknowledgedSequence(calm.site);

  system_.CreateSite(storm_.site);
  robot_ = system_.StartReplay(storm_, system_.server());
  int kills = 0;
  int kills_amid_mapping = 0;
  for (const Victim victim : VictimsInRandomOrder(random_)) {
    // Most kills wait until records flow again after the previous kill, the others do not.
    if (std::uniform_int_distribution<int>(0, 3)(random_) > 0) {
      const std::int64_t before = system_.AcknowledgedSequence(storm_.site);
      ASSERT_TRUE(Eventually([&] { return system_.AcknowledgedSequence(storm_.site) > before; }, kPatience))
          << TailOf(system_.ReplayLog(storm_)) << TailOf(system_.server().log());
    }
    std::this_thread::sleep_for(RandomTime(700));
    const std::int64_t mapped = system_.MappedSequence(storm_.site);
    ASSERT_NO_FATAL_FAILURE(ExpectAllAlive());
    KillAndRestart(victim);
    ++kills;
    if (mapped > 0 && mapped < records && victim != Victim::kRobot) ++kills_amid_mapping;
  }
  EXPECT_GE(kills, 30);
  EXPECT_GE(kills_amid_mapping, 10);
  std::cout << kills << " kills, the last one after " << system_.AcknowledgedSequence(storm_.site) << " of " << records
            << " records; " << kills_amid_mapping << " of server or database with a checkpoint to continue from"
            << std::endl;

  robot_->Kill();
  storm_.rate = "max";  // the rest needs no pace
  robot_ = system_.StartReplay(storm_, system_.server());
  ASSERT_EQ(robot_->Wait(std::chrono::minutes(10)), 0)
      << TailOf(system_.ReplayLog(storm_)) << TailOf(system_.server().log());

  // Stored: every record once, without holes, and with the same content.
  const std::string mine = " FROM session_records WHERE site_id = 'storm' AND session_id = 'drive'";
  EXPECT_EQ(system_.Query("SELECT count(*)" + mine), std::to_string(records));
  EXPECT_EQ(system_.Query("SELECT count(DISTINCT sequence)" + mine), std::to_string(records));
  EXPECT_EQ(system_.Query("SELECT min(sequence)" + mine), "1");
  EXPECT_EQ(system_.Query("SELECT max(sequence)" + mine), std::to_string(records));
  const auto expect_same = [&](const std::string& columns, const std::string& table) {
    const std::string storm = "(SELECT " + columns + " FROM " + table + " WHERE site_id = 'storm')";
    const std::string calm_ones = "(SELECT " + columns + " FROM " + table + " WHERE site_id = 'calm')";
    EXPECT_NE(system_.Query("SELECT count(*) FROM " + storm + " s"), "0") << table;
    EXPECT_EQ(system_.Query("SELECT count(*) FROM (" + storm + " EXCEPT ALL " + calm_ones + ") d"), "0") << table;
    EXPECT_EQ(system_.Query("SELECT count(*) FROM (" + calm_ones + " EXCEPT ALL " + storm + ") d"), "0") << table;
  };
  expect_same("session_id, sequence, time_ns, kind, payload", "session_records");
  expect_same("state, acknowledged_sequence, highest_sequence, laser_scans, odometry, payload_bytes", "sessions");

  // Mapped: bit for bit the same.
  expect_same("node_id, sequence, time_ns, x, y, yaw, covariance, submap_id", "slam_nodes");
  expect_same("submap_id, x, y, yaw, finished, content", "slam_submaps");
  expect_same("mapped_sequence, paired, unpaired, used, keyframes, lost, state", "mapping_checkpoints");
  const auto undisturbed = system_.ExportAll(calm.site);
  const auto disturbed = system_.ExportAll(storm_.site);
  ASSERT_EQ(undisturbed.size(), 3u);  // PGM, YAML, trajectory
  ASSERT_EQ(disturbed.size(), 3u);
  for (std::size_t i = 0; i < undisturbed.size(); ++i) {
    EXPECT_EQ(undisturbed[i].first, disturbed[i].first);
    EXPECT_GT(undisturbed[i].second.size(), 50u);
    EXPECT_TRUE(undisturbed[i].second == disturbed[i].second) << undisturbed[i].first << " differs";
  }
}

}  // namespace
}  // namespace enfilade::testing
