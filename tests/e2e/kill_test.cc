// SPDX-License-Identifier: Apache-2.0
// Server, robot and database are killed (kill -9) at random moments of a drive. In the end the stored records and the
// map must equal those of an undisturbed drive.
#include <gtest/gtest.h>

#include <cstdlib>
#include <iostream>
#include <random>

#include "tests/e2e/kill_storm.h"
#include "tests/e2e/whole_system.h"

namespace enfilade::testing {
namespace {

constexpr int kLaps = 6;
constexpr char kPace[] = "1.5";  // times the recorded speed: slow enough to outlast the kills
constexpr int kKills = 30;

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

  WholeSystem system_;
  std::mt19937_64 random_;
};

TEST_F(KillTest, NothingIsLostOrDoubledAndTheMapIsTheSame) {
  ASSERT_EQ(system_.Query("SHOW fsync"), "on");
  ASSERT_EQ(system_.Query("SHOW synchronous_commit"), "on");
  system_.RecordDrive(kLaps);

  const Replay calm{.site = "calm"};
  system_.CreateSite(calm.site);
  const auto robot = system_.StartReplay(calm, system_.server());
  ASSERT_EQ(robot->Wait(std::chrono::minutes(10)), 0) << TailOf(system_.ReplayLog(calm));
  const std::int64_t records = system_.AcknowledgedSequence(calm.site);

  const Replay stormy{.site = "storm", .rate = kPace};
  system_.CreateSite(stormy.site);
  KillStorm storm(system_, stormy, records, random_);
  const StormCounts counts = storm.Run(VictimsInRandomOrder(kKills, random_));
  EXPECT_EQ(counts.total(), kKills);
  EXPECT_GE(counts.amid_mapping, 10);
  std::cout << counts.total() << " kills, the last one after " << system_.AcknowledgedSequence(stormy.site) << " of "
            << records << " records; " << counts.amid_mapping
            << " of server or database with a checkpoint to continue from" << std::endl;
  storm.Finish();

  // Stored: every record once, without holes, and with the same content.
  const StoredRecords stored = CompareStored(system_, stormy, RecordsOfLog(system_.directory() / "drive.jsonl"));
  EXPECT_EQ(stored.lost, 0);
  EXPECT_EQ(stored.doubled, 0);
  EXPECT_EQ(stored.changed, 0);
  const auto expect_same = [&](const std::string& columns, const std::string& table) {
    const std::string storm_ones = "(SELECT " + columns + " FROM " + table + " WHERE site_id = 'storm')";
    const std::string calm_ones = "(SELECT " + columns + " FROM " + table + " WHERE site_id = 'calm')";
    EXPECT_NE(system_.Query("SELECT count(*) FROM " + storm_ones + " s"), "0") << table;
    EXPECT_EQ(system_.Query("SELECT count(*) FROM (" + storm_ones + " EXCEPT ALL " + calm_ones + ") d"), "0") << table;
    EXPECT_EQ(system_.Query("SELECT count(*) FROM (" + calm_ones + " EXCEPT ALL " + storm_ones + ") d"), "0") << table;
  };
  expect_same("session_id, sequence, time_ns, kind, payload", "session_records");
  expect_same("state, acknowledged_sequence, highest_sequence, laser_scans, odometry, payload_bytes", "sessions");

  // Mapped: bit for bit the same.
  expect_same("node_id, sequence, time_ns, x, y, yaw, covariance, submap_id", "slam_nodes");
  expect_same("submap_id, x, y, yaw, finished, content", "slam_submaps");
  expect_same("mapped_sequence, paired, unpaired, used, keyframes, lost, state", "mapping_checkpoints");
  const auto undisturbed = system_.ExportAll(calm.site);
  const auto disturbed = system_.ExportAll(stormy.site);
  ASSERT_EQ(undisturbed.size(), 3u);  // PGM, YAML, trajectory
  ASSERT_EQ(disturbed.size(), 3u);
  for (std::size_t i = 0; i < undisturbed.size(); ++i) {
    EXPECT_EQ(undisturbed[i].first, disturbed[i].first);
    EXPECT_GT(undisturbed[i].second.size(), 50u);
    EXPECT_TRUE(undisturbed[i].second == disturbed[i].second) << undisturbed[i].first << " differs";
  }

  // The comparison of the stored records is no blind one.
  const std::string one = " WHERE site_id = 'storm' AND sequence = ";
  system_.Query("UPDATE session_records SET payload = payload || '\\x00'" + one + "2 RETURNING 1");
  system_.Query("DELETE FROM session_records" + one + "3 RETURNING 1");
  system_.Query("UPDATE session_records SET sequence = 1000000" + one + "4 RETURNING 1");
  const StoredRecords damaged = CompareStored(system_, stormy, RecordsOfLog(system_.directory() / "drive.jsonl"));
  EXPECT_EQ(damaged.changed, 1);
  EXPECT_EQ(damaged.lost, 2);
  EXPECT_EQ(damaged.doubled, 1);
}

}  // namespace
}  // namespace enfilade::testing
