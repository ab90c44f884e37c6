// SPDX-License-Identifier: Apache-2.0
#include "core/sensor/scan_pairing.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"

namespace enfilade::sensor {
namespace {

using testing::PoseNear;

LaserScan ScanAt(double seconds) {
  LaserScan scan;
  scan.time = static_cast<TimeNs>(seconds * 1e9);
  scan.ranges = {1.0F};
  return scan;
}

Odometry OdometryAt(double seconds, double x) { return {static_cast<TimeNs>(seconds * 1e9), {x, 0, 0}}; }

class ScanPairingTest : public ::testing::Test {
 protected:
  ScanPairing pairing_{ScanPairingOptions{.window_s = 0.5, .max_waiting_scans = 4}};
  std::vector<PairedScan> settled_;
};

TEST_F(ScanPairingTest, InterpolatesBetweenNeighbours) {
  pairing_.Add(OdometryAt(1.0, 10.0), settled_);
  pairing_.Add(7, ScanAt(1.25), settled_);
  EXPECT_TRUE(settled_.empty()) << "the odometry after the scan is still to come";
  pairing_.Add(OdometryAt(2.0, 20.0), settled_);
  ASSERT_EQ(settled_.size(), 1U);
  EXPECT_EQ(settled_[0].sequence, 7);
  // The neighbour after lies outside the window: the one before is the nearest.
  EXPECT_THAT(*settled_[0].T_odom_robot, PoseNear(Pose2{10.0, 0, 0}, 1e-9, 1e-9));

  pairing_.Add(8, ScanAt(2.1), settled_);
  pairing_.Add(OdometryAt(2.4, 24.0), settled_);
  ASSERT_EQ(settled_.size(), 2U);
  EXPECT_THAT(*settled_[1].T_odom_robot, PoseNear(Pose2{21.0, 0, 0}, 1e-9, 1e-9));
}

TEST_F(ScanPairingTest, TakesRecordsOfAnyKind) {
  pairing_.Add(1, RecordPayload(OdometryAt(1.0, 10.0)), settled_);
  pairing_.Add(2, RecordPayload(Image{}), settled_);
  pairing_.Add(3, RecordPayload(ScanAt(1.0)), settled_);
  ASSERT_EQ(settled_.size(), 1U);
  EXPECT_EQ(settled_[0].sequence, 3);
  EXPECT_EQ(settled_[0].T_odom_robot->x, 10.0);
}

TEST_F(ScanPairingTest, SettlesImmediatelyIfTimesAreEqual) {
  pairing_.Add(OdometryAt(1.0, 10.0), settled_);
  pairing_.Add(1, ScanAt(1.0), settled_);
  ASSERT_EQ(settled_.size(), 1U);
  EXPECT_EQ(settled_[0].T_odom_robot->x, 10.0);
}

TEST_F(ScanPairingTest, DeliversScansWithoutOdometryUnpairedAndCountsThem) {
  pairing_.Add(1, ScanAt(1.0), settled_);
  pairing_.Add(2, ScanAt(1.2), settled_);
  pairing_.Add(3, ScanAt(1.6), settled_);  // past the window of the first
  ASSERT_EQ(settled_.size(), 1U);
  EXPECT_FALSE(settled_[0].T_odom_robot);
  pairing_.Flush(settled_);
  EXPECT_EQ(settled_.size(), 3U);
  EXPECT_EQ(pairing_.counts().unpaired, 3);
}

TEST_F(ScanPairingTest, NeverHoldsBackMoreThanItsLimit) {
  for (int i = 0; i < 100; ++i) pairing_.Add(i + 1, ScanAt(1.0 + 1e-3 * i), settled_);
  EXPECT_EQ(settled_.size(), 96U);
}

TEST_F(ScanPairingTest, DropsAndCountsTimesRunningBackwards) {
  pairing_.Add(OdometryAt(2.0, 1.0), settled_);
  pairing_.Add(OdometryAt(1.0, 5.0), settled_);
  pairing_.Add(1, ScanAt(2.0), settled_);
  pairing_.Add(2, ScanAt(1.5), settled_);
  pairing_.Flush(settled_);
  ASSERT_EQ(settled_.size(), 1U);
  EXPECT_EQ(settled_[0].T_odom_robot->x, 1.0);
  EXPECT_EQ(pairing_.counts().time_reversed, 2);
}

TEST_F(ScanPairingTest, ContinuesUnchangedAfterRestoreAtAnyPoint) {
  struct Step {
    double time;
    bool is_scan;
  };
  std::vector<Step> steps;
  for (int i = 0; i < 60; ++i) steps.push_back({1.0 + 0.13 * i, i % 3 == 0});
  const auto run = [&](std::size_t restore_at) {
    ScanPairing pairing(ScanPairingOptions{});
    std::vector<PairedScan> settled;
    for (std::size_t i = 0; i < steps.size(); ++i) {
      if (i == restore_at) {
        auto restored = ScanPairing::Restore(ScanPairingOptions{}, pairing.Serialize());
        EXPECT_OK(restored);
        pairing = *std::move(restored);
      }
      if (steps[i].is_scan) {
        pairing.Add(static_cast<std::int64_t>(i), ScanAt(steps[i].time), settled);
      } else {
        pairing.Add(OdometryAt(steps[i].time, steps[i].time), settled);
      }
    }
    pairing.Flush(settled);
    return settled;
  };
  const auto expected = run(steps.size());
  ASSERT_EQ(expected.size(), 20U);
  for (std::size_t at = 0; at < steps.size(); ++at) {
    const auto actual = run(at);
    ASSERT_EQ(actual.size(), expected.size());
    for (std::size_t i = 0; i < actual.size(); ++i) EXPECT_EQ(actual[i].T_odom_robot, expected[i].T_odom_robot);
  }
}

struct Event {
  TimeNs time = 0;
  bool is_scan = false;
};

// Records in order of time, as robots send them.
std::vector<Event> RandomLog(std::mt19937_64& random) {
  std::vector<Event> events;
  TimeNs time = kNsPerSecond;
  for (int i = 0; i < 120; ++i) {
    // Gaps of up to 0.4 s, now and then one of more than the window.
    time += static_cast<TimeNs>(random() % (random() % 12 == 0 ? 2'000'000'000 : 400'000'000));
    events.push_back({time, random() % 3 == 0});
  }
  return events;
}

Pose2 TruthAt(TimeNs time) { return {ToSeconds(time), 2.0 * ToSeconds(time), 0.0}; }

// The rule of ScanPairingOptions, with all odometry known.
std::optional<Pose2> ExpectedPose(const std::vector<Event>& events, TimeNs time) {
  constexpr TimeNs kWindow = kNsPerSecond / 2;
  std::optional<TimeNs> before;
  std::optional<TimeNs> after;
  for (const Event& event : events) {
    if (event.is_scan) continue;
    if (event.time <= time && time - event.time <= kWindow) before = event.time;
    if (event.time >= time && event.time - time <= kWindow && !after) after = event.time;
  }
  if (before && after) return TruthAt(time);  // linear motion, so interpolation is exact
  if (after) return TruthAt(*after);
  if (before) return TruthAt(*before);
  return std::nullopt;
}

TEST(ScanPairingProperties, OrderedLogsArePairedByTheNearestOdometry) {
  std::mt19937_64 random(5);
  int unpaired = 0;
  for (int trial = 0; trial < 50; ++trial) {
    const std::vector<Event> events = RandomLog(random);
    ScanPairing pairing(ScanPairingOptions{});
    std::vector<PairedScan> settled;
    std::vector<TimeNs> scans;
    for (std::size_t i = 0; i < events.size(); ++i) {
      if (events[i].is_scan) {
        LaserScan scan;
        scan.time = events[i].time;
        scans.push_back(scan.time);
        pairing.Add(static_cast<std::int64_t>(i + 1), scan, settled);
      } else {
        pairing.Add(Odometry{events[i].time, TruthAt(events[i].time)}, settled);
      }
    }
    pairing.Flush(settled);
    ASSERT_EQ(settled.size(), scans.size());
    for (std::size_t i = 0; i < settled.size(); ++i) {
      EXPECT_EQ(settled[i].scan.time, scans[i]) << "scans keep their order";
      const std::optional<Pose2> expected = ExpectedPose(events, scans[i]);
      ASSERT_EQ(settled[i].T_odom_robot.has_value(), expected.has_value()) << trial << ", " << i;
      if (!expected) {
        ++unpaired;
        continue;
      }
      EXPECT_THAT(*settled[i].T_odom_robot, PoseNear(*expected, 1e-6, 1e-9)) << trial << ", " << i;
    }
    EXPECT_EQ(pairing.counts().paired + pairing.counts().unpaired, static_cast<std::int64_t>(scans.size()));
    EXPECT_EQ(pairing.counts().time_reversed, 0);
  }
  EXPECT_GT(unpaired, 10) << "the logs have gaps beyond the window";
}

TEST(ScanPairingProperties, RefusesDamagedState) {
  ScanPairing pairing(ScanPairingOptions{});
  std::vector<PairedScan> settled;
  for (int i = 0; i < 5; ++i) {
    pairing.Add(OdometryAt(1.0 + 0.1 * i, i), settled);
    pairing.Add(i, ScanAt(1.05 + 0.1 * i), settled);
  }
  const std::string bytes = pairing.Serialize();
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_CODE(ScanPairing::Restore({}, std::string_view(bytes).substr(0, size)), absl::StatusCode::kDataLoss) << size;
  }
  EXPECT_CODE(ScanPairing::Restore({}, bytes + "x"), absl::StatusCode::kDataLoss);
  std::mt19937_64 random(6);
  for (int trial = 0; trial < 300; ++trial) {
    std::string mutated = bytes;
    mutated[random() % mutated.size()] = static_cast<char>(random());
    (void)ScanPairing::Restore({}, mutated);  // an error or a state, but no crash and no huge allocation
  }
}

}  // namespace
}  // namespace enfilade::sensor
