// SPDX-License-Identifier: Apache-2.0
// The logs of Wean Hall and Mines Paris: their fields, their errors, and clocks that run backwards.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/client/sources/log_files.h"

namespace enfilade::sources {
namespace {

using testing::AllOf;
using ::testing::HasSubstr;
using testing::LogFiles;
using testing::ReadAll;
using testing::ReadLog;

std::string Repeated(const std::string& field, int count) {
  std::string text;
  for (int i = 0; i < count; ++i) text += " " + field;
  return text;
}

std::string WeanOdometry(const std::string& x, const std::string& time) { return "O " + x + " 20 0.5 " + time + "\n"; }
std::string WeanScan(const std::string& range, const std::string& time, int beams = 180) {
  return "L 10 20 0 35 20 0" + Repeated(range, beams) + " " + time + "\n";
}
// `microseconds`, left and right wheel ticks.
std::string MinesLine(const std::string& microseconds, int left, int right, const std::string& range = "1500",
                      int beams = 682) {
  return microseconds + " 0 " + std::to_string(left) + " " + std::to_string(right) + Repeated("0", 20) +
         Repeated(range, beams) + " 0\n";
}

struct BadOldLine {
  const char* name;
  const char* file;
  std::string good;
  std::string bad;
  const char* message;
};

class OldFormatBadLine : public ::testing::TestWithParam<BadOldLine> {};

TEST_P(OldFormatBadLine, IsRefusedWholeNamingLineAndField) {
  const BadOldLine& param = GetParam();
  const LogFiles files;
  const auto path = files.Write(param.file, param.good + param.bad + param.good);
  const ReadLog log = ReadAll(path);
  EXPECT_STATUS(log.status, absl::StatusCode::kInvalidArgument, HasSubstr(path.string() + ":2: "));
  EXPECT_STATUS(log.status, absl::StatusCode::kInvalidArgument, HasSubstr(param.message));
  const std::size_t per_line = log.entries.size();
  EXPECT_GE(per_line, 1U);

  LogOptions skip;
  skip.skip_bad_lines = true;
  const ReadLog rest = ReadAll(path, skip);
  EXPECT_OK(rest.status);
  EXPECT_EQ(rest.entries.size(), 2 * per_line) << "a bad line delivers nothing";
  EXPECT_EQ(rest.counts.bad_lines, 1);
  EXPECT_EQ(rest.counts.lines, 3);
}

INSTANTIATE_TEST_SUITE_P(
    WeanHall, OldFormatBadLine,
    ::testing::Values(
        BadOldLine{"UnknownTag", "w.log", WeanOdometry("1", "1"), "X 1 2 3 4\n", "expected O or L"},
        BadOldLine{"ShortOdometry", "w.log", WeanOdometry("1", "1"), "O 1 2\n", "before field 4 (robot pose.theta)"},
        BadOldLine{"LongOdometry", "w.log", WeanOdometry("1", "1"), "O 1 2 3 4 5\n", "fields follow"},
        BadOldLine{"WordInThePose", "w.log", WeanOdometry("1", "1"), WeanOdometry("here", "1"),
                   "field 2 (robot pose.x) is \"here\""},
        BadOldLine{"InfinitePose", "w.log", WeanOdometry("1", "1"), WeanOdometry("inf", "1"), "finite"},
        BadOldLine{"BadTime", "w.log", WeanOdometry("1", "1"), WeanOdometry("1", "noon"), "(time) is \"noon\""},
        BadOldLine{"ScanTooShort", "w.log", WeanOdometry("1", "1"), WeanScan("100", "1", 179),
                   "before field 188 (time)"},
        BadOldLine{"ScanTooLong", "w.log", WeanOdometry("1", "1"), WeanScan("100", "1", 181), "fields follow"},
        BadOldLine{"WordAmongRanges", "w.log", WeanScan("100", "1"), WeanScan("far", "1"), "range 1 of 180"},
        BadOldLine{"CutOff", "w.log", WeanScan("100", "1"), "L 10 20\n", "before field 4"}),
    [](const auto& param) { return param.param.name; });

INSTANTIATE_TEST_SUITE_P(
    MinesParis, OldFormatBadLine,
    ::testing::Values(
        BadOldLine{"Empty", "m.dat", MinesLine("0", 0, 0), "nothing\n", "(time in us) is \"nothing\""},
        BadOldLine{"OneRangeTooFew", "m.dat", MinesLine("0", 0, 0), MinesLine("1", 0, 0, "1500", 681), "field 707"},
        BadOldLine{"OneRangeTooMany", "m.dat", MinesLine("0", 0, 0), MinesLine("1", 0, 0, "1500", 683),
                   "fields follow"},
        BadOldLine{"TicksOfAFraction", "m.dat", MinesLine("0", 0, 0),
                   "1 0 1.5 0" + Repeated("0", 20) + Repeated("1", 682) + " 0\n", "(left wheel ticks) is \"1.5\""},
        BadOldLine{"NanTime", "m.dat", MinesLine("0", 0, 0), MinesLine("nan", 0, 0), "finite"},
        BadOldLine{"WordForARange", "m.dat", MinesLine("0", 0, 0), MinesLine("1", 0, 0, "x"), "range 1 of 682"}),
    [](const auto& param) { return param.param.name; });

TEST(WeanHall, ConvertsCentimetres) {
  const LogFiles files;
  const ReadLog log = ReadAll(files.Write("w.log", WeanOdometry("150", "1.5") + WeanScan("250", "2.5")));
  ASSERT_OK(log.status);
  const auto odometry = AllOf<sensor::Odometry>(log);
  ASSERT_EQ(odometry.size(), 2U);
  EXPECT_THAT(odometry[0].T_odom_robot, testing::PoseNear(Pose2{1.5, 0.2, 0.5}, 1e-12, 1e-12));
  const sensor::LaserScan scan = AllOf<sensor::LaserScan>(log).at(0);
  EXPECT_EQ(scan.ranges.size(), 180U);
  EXPECT_EQ(scan.ranges[7], 2.5F);
  EXPECT_THAT(scan.T_robot_laser, testing::PoseNear(Pose2{0.25, 0.0, 0.0}, 1e-12, 1e-12));
  EXPECT_EQ(scan.time, odometry[1].time) << "a scan comes with its odometry";
}

TEST(WeanHall, FieldOfViewAndRangeCanBeSet) {
  const LogFiles files;
  LogOptions options;
  options.field_of_view = M_PI / 2.0;
  options.range_max = 3.0;
  const ReadLog log = ReadAll(files.Write("w.log", WeanScan("250", "1") + WeanScan("350", "2")), options);
  ASSERT_OK(log.status);
  const auto scans = AllOf<sensor::LaserScan>(log);
  EXPECT_NEAR(scans.at(0).angle_min, -M_PI / 4.0, 1e-12);
  EXPECT_NEAR(scans.at(0).angle_increment, M_PI / 2.0 / 180.0, 1e-12);
  EXPECT_EQ(scans.at(0).range_max, 3.0F);
  EXPECT_EQ(log.counts.beams_no_return, 180);
}

TEST(MinesParis, IntegratesTheWheels) {
  const LogFiles files;
  // A quarter turn of both wheels, then on the spot to the left.
  const ReadLog log = ReadAll(files.Write(
      "m.dat", MinesLine("0", 1000, 1000) + MinesLine("100000", 1500, 1500) + MinesLine("200000", 1400, 1600)));
  ASSERT_OK(log.status);
  const auto odometry = AllOf<sensor::Odometry>(log);
  ASSERT_EQ(odometry.size(), 3U);
  EXPECT_EQ(odometry[0].T_odom_robot, Pose2{}) << "the first ticks are the origin";
  const double quarter_turn = 2.0 * M_PI * 0.077 * 500.0 / 2000.0;
  EXPECT_THAT(odometry[1].T_odom_robot, testing::PoseNear(Pose2{quarter_turn, 0.0, 0.0}, 1e-12, 1e-12));
  const double turn = 2.0 * (2.0 * M_PI * 0.077 * 100.0 / 2000.0) / 0.33;
  EXPECT_THAT(odometry[2].T_odom_robot, testing::PoseNear(Pose2{quarter_turn, 0.0, turn}, 1e-12, 1e-12));
  EXPECT_EQ(odometry[2].time - odometry[0].time, 200'000'000);
  EXPECT_EQ(AllOf<sensor::LaserScan>(log).at(0).range_max, 5.6F) << "the scanner's range, whatever it read";
}

TEST(MinesParis, ABadLineDoesNotMoveTheRobot) {
  const LogFiles files;
  LogOptions skip;
  skip.skip_bad_lines = true;
  const ReadLog log = ReadAll(
      files.Write("m.dat", MinesLine("0", 0, 0) + MinesLine("1", 9000, 0, "x") + MinesLine("2", 100, 100)), skip);
  ASSERT_OK(log.status);
  EXPECT_NEAR(AllOf<sensor::Odometry>(log).at(1).T_odom_robot.yaw, 0.0, 1e-12);
}

// Ten lines whose times run forwards but for the sixth, in each of the formats.
struct Clock {
  const char* name;
  const char* file;
  std::string (*line)(int second);
};

class ClocksThatJump : public ::testing::TestWithParam<Clock> {
 protected:
  ReadLog Read(bool jump) const {
    std::string text;
    for (int i = 0; i < 10; ++i) text += GetParam().line(jump && i == 5 ? 100 : 200 + i);
    return ReadAll(files_.Write(GetParam().file, text));
  }

  LogFiles files_;
};

TEST_P(ClocksThatJump, AreCountedAndDeliveredUnchanged) {
  const ReadLog straight = Read(false);
  ASSERT_OK(straight.status);
  EXPECT_EQ(straight.counts.scans_back_in_time, 0);
  EXPECT_EQ(straight.counts.odometry_back_in_time, 0);
  const ReadLog jumped = Read(true);
  ASSERT_OK(jumped.status);
  ASSERT_EQ(jumped.entries.size(), straight.entries.size());
  EXPECT_FALSE(jumped.facts.synthetic_times);
  EXPECT_EQ(jumped.counts.scans_back_in_time, 1);
  const auto scans = AllOf<sensor::LaserScan>(jumped);
  ASSERT_EQ(scans.size(), 10U);
  EXPECT_EQ(scans[4].time, 204 * kNsPerSecond);
  EXPECT_EQ(scans[5].time, 100 * kNsPerSecond);
  EXPECT_EQ(scans[6].time, 206 * kNsPerSecond);
}

INSTANTIATE_TEST_SUITE_P(
    All, ClocksThatJump,
    ::testing::Values(
        Clock{"Carmen", "c.log",
              [](int second) {
                return testing::FlaserLine({"1", "2", "3"}, std::to_string(second), std::to_string(second));
              }},
        Clock{"WeanHall", "w.log", [](int second) { return WeanScan("100", std::to_string(second)); }},
        Clock{"MinesParis", "m.dat", [](int second) { return MinesLine(std::to_string(second) + "000000", 0, 0); }},
        Clock{"JsonLines", "j.jsonl",
              [](int second) {
                return "{\"type\":\"scan\",\"time_ns\":" + std::to_string(second) +
                       "000000000,\"angle_min_rad\":0,\"angle_increment_rad\":0.1,\"range_min_m\":0,"
                       "\"range_max_m\":9,\"ranges_m\":[1,2]}\n";
              }}),
    [](const auto& param) { return param.param.name; });

TEST_P(ClocksThatJump, CompressedLogsAndCutOnesKeepTheirLines) {
  std::string text;
  for (int i = 0; i < 50; ++i) text += GetParam().line(200 + i);
  const ReadLog plain = ReadAll(files_.Write(GetParam().file, text));
  ASSERT_OK(plain.status);
  const auto compressed = files_.WriteGz("z.gz", text);
  EXPECT_EQ(ReadAll(compressed).entries, plain.entries);
  const std::string whole = testing::Contents(compressed);
  const ReadLog cut = ReadAll(files_.Write("cut.gz", whole.substr(0, whole.size() - 12)));
  EXPECT_CODE(cut.status, absl::StatusCode::kInvalidArgument);
  EXPECT_LE(cut.entries.size(), plain.entries.size());
  for (std::size_t i = 0; i < cut.entries.size(); ++i) ASSERT_EQ(cut.entries[i], plain.entries[i]);
}

}  // namespace
}  // namespace enfilade::sources
