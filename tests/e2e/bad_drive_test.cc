// SPDX-License-Identifier: Apache-2.0
// Logs in which something went wrong, driven by `enfilade robot LOG` against a real server: what is mapped must be
// right, and what cannot be used must be said. The logs are simulated drives, edited.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "client/simulator/simulation.h"
#include "client/simulator/simulation_files.h"
#include "client/sources/formats/json_lines_writer.h"
#include "tests/e2e/campus/comparison.h"
#include "tests/e2e/campus/drive_truth.h"
#include "tests/e2e/campus/json_lines.h"
#include "tests/e2e/campus/mapped_state.h"
#include "tests/e2e/whole_system.h"
#include "tests/support/slowdown.h"

namespace enfilade::testing {
namespace {

using nlohmann::json;

constexpr const char* kCampus = "random:14001";
constexpr const char* kRobot = "robot";
constexpr TimeNs kDay = 24 * 3600 * kNsPerSecond;

using Log = std::vector<sensor::RecordPayload>;

void SetTime(sensor::RecordPayload& payload, TimeNs time) {
  if (auto* scan = std::get_if<sensor::LaserScan>(&payload)) scan->time = time;
  if (auto* odometry = std::get_if<sensor::Odometry>(&payload)) odometry->time = time;
}

struct Outcome {
  Comparison comparison;
  std::vector<json> events;
  int failed = 0;  // sessions

  // The events of that name.
  std::vector<json> Of(const std::string& event) const {
    std::vector<json> found;
    for (const json& one : events) {
      if (one.value("event", "") == event) found.push_back(one);
    }
    return found;
  }
};

class BadDriveTest : public ::testing::Test {
 protected:
  BadDriveTest() : system_({}) {
    system_.CreateSite("s");
    auto drive = simulator::SimulateDrive(world_, kRobot, {});
    if (!drive.ok()) throw std::runtime_error(std::string(drive.status().message()));
    for (simulator::SimulatedRecord& record : drive->records) log_.push_back(std::move(record.payload));
    const std::filesystem::path file = system_.directory() / "truth.jsonl";
    std::ofstream(file) << simulator::TruthLines(drive->truth);
    truth_ = ReadTruth(kRobot, file);
    begin_ = sensor::TimeOf(log_.front());
  }

  // `s` seconds after the start of the drive.
  TimeNs At(double s) const { return begin_ + std::llround(s * 1e9); }
  // Removes what is recorded between the two moments from log and truth.
  void Cut(TimeNs from, TimeNs to) {
    std::erase_if(log_, [&](const sensor::RecordPayload& record) {
      return sensor::TimeOf(record) >= from && sensor::TimeOf(record) < to;
    });
    const auto inside = [&](const auto& one) { return one.time >= from && one.time < to; };
    std::erase_if(truth_.poses, inside);
    std::erase_if(truth_.passages, inside);
  }
  // From `from` on, the odometry frame is `T_new_old` of what it was.
  void MoveOdometry(TimeNs from, const Pose2& T_new_old) {
    for (sensor::RecordPayload& record : log_) {
      auto* odometry = std::get_if<sensor::Odometry>(&record);
      if (odometry && odometry->time >= from) odometry->T_odom_robot = T_new_old * odometry->T_odom_robot;
    }
  }
  Pose2 OdometryAt(TimeNs time) const {
    const auto found = std::find_if(log_.begin(), log_.end(), [&](const sensor::RecordPayload& record) {
      return std::holds_alternative<sensor::Odometry>(record) && sensor::TimeOf(record) >= time;
    });
    return std::get<sensor::Odometry>(*found).T_odom_robot;
  }

  Outcome Drive() {
    const std::filesystem::path file = system_.directory() / "log.jsonl";
    {
      std::ofstream out(file);
      out << sources::JsonLinesHeader();
      for (const sensor::RecordPayload& record : log_) out << *sources::ToJsonLine({record, {}});
    }
    const std::filesystem::path output = system_.directory() / "out.jsonl";
    Process robot({Program("enfilade"), "--json", "--server", system_.server().address(), "--site", "s", "robot",
                   file.string(), "--robot", kRobot, "--spool", (system_.directory() / "spool").string(), "--wait"},
                  output);
    if (robot.Wait(std::chrono::minutes(10 * kSlowdown)) != 0) throw std::runtime_error(TailOf(output));
    Outcome outcome;
    outcome.events = ReadJsonLines(output);
    const MappedState state = ReadWhenQuiet(system_.server().Connect(), "s", {kRobot});
    outcome.comparison = Compare({truth_}, DoorsOf(world_->campus()), state);
    outcome.failed = std::stoi(system_.Query("SELECT count(*) FROM sessions WHERE state = 4"));
    return outcome;
  }

  // Doors that the robot did not go through while it recorded may be missing.
  static void ExpectRightMaps(const Outcome& outcome) {
    const Comparison& comparison = outcome.comparison;
    const std::string wrong = ::testing::PrintToString(comparison.wrong);
    EXPECT_EQ(outcome.failed, 0);
    EXPECT_EQ(comparison.areas_doubled, 0) << wrong;
    EXPECT_EQ(comparison.areas_missing, 0) << wrong;
    EXPECT_EQ(comparison.maps_extra, 0) << wrong;
    EXPECT_EQ(comparison.joins_false, 0) << wrong;
    EXPECT_EQ(comparison.components, 1) << wrong;
    EXPECT_EQ(comparison.false_placements, 0) << wrong;
    EXPECT_LT(comparison.unmapped_s, 2.0);
  }

  const std::shared_ptr<const simulator::World> world_ =
      std::make_shared<const simulator::World>(*simulator::LoadCampus(kCampus));
  WholeSystem system_;
  Log log_;
  DriveTruth truth_;
  TimeNs begin_ = 0;
};

TEST_F(BadDriveTest, ADriveWithNothingWrongIsExact) {
  const Outcome outcome = Drive();
  EXPECT_TRUE(outcome.comparison.exact);
  EXPECT_TRUE(outcome.Of("clock").empty());
  EXPECT_TRUE(outcome.Of("bad_input").empty());
  EXPECT_TRUE(outcome.Of("located").at(0).at("map").is_null()) << "the site was empty";
  EXPECT_EQ(outcome.Of("located").size(), 1U) << "nothing was interrupted";
}

// It stands elsewhere from one scan to the next, and odometry has not noticed.
TEST_F(BadDriveTest, CarriedWhileOdometryStandsStill) {
  const Pose2 before = OdometryAt(At(100));
  const Pose2 after = OdometryAt(At(160));
  Cut(At(100), At(160));
  MoveOdometry(At(160), before * Inverse(after));
  const Outcome outcome = Drive();
  ExpectRightMaps(outcome);
  EXPECT_EQ(outcome.Of("located").size(), 2U) << "at the start, and anew";
}

TEST_F(BadDriveTest, CarriedWhileOdometryJumps) {
  Cut(At(100), At(160));
  MoveOdometry(At(160), {20.0, -7.0, 2.0});
  const Outcome outcome = Drive();
  ExpectRightMaps(outcome);
  EXPECT_EQ(outcome.Of("located").size(), 2U);
}

TEST_F(BadDriveTest, BeginsInTheMiddleOfADoor) {
  Cut(0, truth_.passages.at(2).time);
  const Outcome outcome = Drive();
  ExpectRightMaps(outcome);
  EXPECT_LT(outcome.comparison.position_max, 0.5);
}

TEST_F(BadDriveTest, ClockIsSetBackByTenSeconds) {
  for (auto& record : log_) {
    if (sensor::TimeOf(record) >= At(100)) SetTime(record, sensor::TimeOf(record) - 10 * kNsPerSecond);
  }
  const Outcome outcome = Drive();
  EXPECT_TRUE(outcome.comparison.exact) << ::testing::PrintToString(outcome.comparison.wrong);
  ASSERT_EQ(outcome.Of("clock").size(), 1U);
  EXPECT_NEAR(outcome.Of("clock")[0].at("back_s").get<double>(), 10.0, 0.1);
}

TEST_F(BadDriveTest, ClockIsSetForwardByADay) {
  for (auto& record : log_) {
    if (sensor::TimeOf(record) >= At(100)) SetTime(record, sensor::TimeOf(record) + kDay);
  }
  const TimeNs set = At(100);
  for (TruePoint& pose : truth_.poses) pose.time += pose.time >= set ? kDay : 0;
  for (PassedDoor& passage : truth_.passages) passage.time += passage.time >= set ? kDay : 0;
  const Outcome outcome = Drive();
  EXPECT_TRUE(outcome.comparison.exact) << ::testing::PrintToString(outcome.comparison.wrong);
  EXPECT_EQ(outcome.Of("bad_input").size(), 1U) << "the first record had to be confirmed";
}

TEST_F(BadDriveTest, OneRecordIsADayAhead) {
  for (auto& record : log_) {
    if (sensor::TimeOf(record) < At(100)) continue;
    SetTime(record, sensor::TimeOf(record) + kDay);
    break;
  }
  const Outcome outcome = Drive();
  EXPECT_TRUE(outcome.comparison.exact) << ::testing::PrintToString(outcome.comparison.wrong);
  EXPECT_EQ(outcome.Of("bad_input").size(), 1U);
}

TEST_F(BadDriveTest, ClockRunsBackwards) {
  for (auto& record : log_) SetTime(record, 2 * begin_ - sensor::TimeOf(record));
  const Outcome outcome = Drive();
  EXPECT_GT(outcome.Of("bad_input").size(), 0.95 * static_cast<double>(log_.size())) << "it says so";
  EXPECT_LE(outcome.comparison.maps, 1);
  EXPECT_EQ(outcome.failed, 0);
  EXPECT_EQ(system_.Query("SELECT coalesce(sum(keyframes), 0) <= 1 FROM mapping_checkpoints"), "t");
}

// The wheels' encoders say nothing: SLAM follows the scans.
TEST_F(BadDriveTest, OdometryIsZero) {
  for (auto& record : log_) {
    if (auto* odometry = std::get_if<sensor::Odometry>(&record)) odometry->T_odom_robot = {};
  }
  const Outcome outcome = Drive();
  ExpectRightMaps(outcome);
  EXPECT_LT(outcome.comparison.position_max, 0.5);
}

TEST_F(BadDriveTest, ScannerSeesNothingForAMinute) {
  for (auto& record : log_) {
    auto* scan = std::get_if<sensor::LaserScan>(&record);
    if (scan == nullptr || scan->time < At(100) || scan->time >= At(160)) continue;
    scan->ranges.assign(scan->ranges.size(), std::numeric_limits<float>::infinity());
  }
  const Outcome outcome = Drive();
  EXPECT_EQ(outcome.comparison.areas_doubled, 0);
  EXPECT_EQ(outcome.comparison.maps_extra, 0);
  EXPECT_EQ(outcome.comparison.joins_false, 0);
  EXPECT_EQ(outcome.comparison.components, 1);
  EXPECT_LT(outcome.comparison.position_max, 1.0) << "the 5 m that it drove blind";
  EXPECT_EQ(outcome.Of("located").size(), 2U);
}

}  // namespace
}  // namespace enfilade::testing
