// SPDX-License-Identifier: Apache-2.0
#include "tests/e2e/campus/log_run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "client/sources/formats/json_lines_writer.h"
#include "client/sources/log_reader.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"

namespace enfilade::testing {
namespace {

// A log whose odometry is 20 m straight ahead, in steps of 0.1 m.
class ChangedOdometryTest : public ::testing::Test {
 protected:
  ChangedOdometryTest() {
    std::ofstream out(File("log.jsonl"));
    out << sources::JsonLinesHeader();
    for (int i = 0; i <= 200; ++i) {
      const auto line = sources::ToJsonLine({sensor::Odometry{i * kNsPerSecond, {0.1 * i, 1.0, 0.0}}, {}});
      EXPECT_OK(line);
      out << *line;
    }
  }
  std::string File(const std::string& name) const { return (directory_.path() / name).string(); }

  std::vector<Pose2> Simulate(std::uint64_t seed) {
    LogRun run;
    run.log = File("log.jsonl");
    run.seed = seed;
    SimulateOdometry(run, File("noisy.jsonl"), File("reference.txt"));
    return ReadOdometry("noisy.jsonl");
  }

  std::vector<Pose2> ReadOdometry(const std::string& name) {
    std::vector<Pose2> poses;
    auto reader = sources::LogReader::Open(File(name));
    EXPECT_OK(reader);
    while (true) {
      const auto entry = reader->Next();
      EXPECT_OK(entry);
      if (!entry.ok() || !*entry) return poses;
      poses.push_back(std::get<sensor::Odometry>((*entry)->payload).T_odom_robot);
    }
  }

  TemporaryDirectory directory_;
};

TEST_F(ChangedOdometryTest, KeepsTheLogsOwnAsReference) {
  EXPECT_EQ(Simulate(1).size(), 201U);
  const std::vector<TimedPose> reference = ReadTrajectory(File("reference.txt"));
  ASSERT_EQ(reference.size(), 201U);
  EXPECT_DOUBLE_EQ(reference.back().pose.x, 20.0);
  EXPECT_DOUBLE_EQ(reference.back().pose.y, 1.0);
}

TEST_F(ChangedOdometryTest, DriftsByTheSeed) {
  const std::vector<Pose2> one = Simulate(1);
  EXPECT_EQ(one.front().x, 0.0) << "it starts at zero";
  const std::vector<Pose2> again = Simulate(1);
  EXPECT_EQ(one.back().x, again.back().x);
  EXPECT_NE(one.back().x, Simulate(2).back().x);
  double squares = 0.0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) squares += std::pow(Simulate(seed).back().yaw, 2);
  const double expected = 3.0 * kDegree * std::sqrt(20.0);  // after 20 m
  EXPECT_GT(std::sqrt(squares / 100.0), 0.8 * expected);
  EXPECT_LT(std::sqrt(squares / 100.0), 1.2 * expected);
}

TEST_F(ChangedOdometryTest, IsDelayedBySamples) {
  DelayOdometry(File("log.jsonl"), 2, File("late.jsonl"));
  const std::vector<Pose2> poses = ReadOdometry("late.jsonl");
  ASSERT_EQ(poses.size(), 201U);
  for (int i = 0; i <= 200; ++i) EXPECT_NEAR(poses[static_cast<std::size_t>(i)].x, 0.1 * std::max(0, i - 2), 1e-9) << i;
}

TEST(LogResult, RatioNeedsBothErrors) {
  LogResult result;
  EXPECT_FALSE(result.ratio());
  result.error = TrajectoryError{0.12, 1.0, 10, 0};
  EXPECT_FALSE(result.ratio());
  result.slam_error = TrajectoryError{0.1, 1.0, 10, 0};
  EXPECT_NEAR(*result.ratio(), 1.2, 1e-9);
}

}  // namespace
}  // namespace enfilade::testing
