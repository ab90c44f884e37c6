// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/client/sources/log_files.h"

namespace enfilade::sources {
namespace {

using sources::LogOptions;
using testing::AllOf;
using ::testing::ElementsAre;
using testing::FlaserLine;
using ::testing::HasSubstr;
using testing::LogFiles;
using ::testing::Pair;
using testing::PoseNear;
using testing::ReadAll;
using testing::ReadLog;

TEST(CarmenParser, ReadsScansWithTheirOdometryInLogOrder) {
  const ReadLog log = ReadAll(testing::ProjectData("logs/small.clf"));
  ASSERT_OK(log.status);
  const auto scans = AllOf<sensor::LaserScan>(log);
  ASSERT_EQ(scans.size(), 7U);
  ASSERT_EQ(AllOf<sensor::Odometry>(log).size(), 13U);
  EXPECT_TRUE(std::holds_alternative<sensor::Odometry>(log.entries[1].payload));
  EXPECT_TRUE(std::holds_alternative<sensor::LaserScan>(log.entries[2].payload));

  EXPECT_EQ(scans[0].time, 976'052'858'304'357'000);
  EXPECT_EQ(scans[1].time, 976'052'858'804'357'000);
  EXPECT_EQ(scans[0].ranges.size(), 9U);
  EXPECT_DOUBLE_EQ(scans[0].angle_min, -M_PI / 2.0);
  EXPECT_NEAR(scans[0].angle(8), M_PI / 2.0, 1e-12);
  EXPECT_EQ(scans[0].range_max, 81.83F);
  EXPECT_EQ(scans[0].T_robot_laser, (Pose2{0.25, 0.0, 0.0}));
  EXPECT_THAT(std::get<sensor::Odometry>(log.entries[4].payload).T_odom_robot,
              PoseNear(Pose2{0.1, 0.0, 0.1}, 1e-12, 1e-12));

  EXPECT_EQ(log.counts.beams_no_return, 6 * 2 + 1);
  EXPECT_EQ(log.counts.comments, 2);
  EXPECT_THAT(log.counts.skipped_lines, ElementsAre(Pair("NEFF", 6), Pair("PARAM", 2), Pair("RLASER", 1)));
  EXPECT_EQ(log.facts.scans, 7);
  EXPECT_EQ(log.facts.entries, 20);
  EXPECT_EQ(log.facts.times, "ipc_timestamp");
}

TEST(CarmenParser, ReadsARobotLaserLinesOwnGeometry) {
  const ReadLog log = ReadAll(testing::ProjectData("logs/small.clf"));
  const sensor::LaserScan scan = AllOf<sensor::LaserScan>(log).back();
  EXPECT_EQ(scan.time, 976'052'862'000'000'001);
  EXPECT_DOUBLE_EQ(scan.angle_min, -1.570796);
  EXPECT_DOUBLE_EQ(scan.angle_increment, 0.785398);
  EXPECT_EQ(scan.range_max, 50.0F);
  EXPECT_THAT(scan.T_robot_laser, PoseNear(Pose2{0.2 * std::cos(0.1), -0.2 * std::sin(0.1), 0.0}, 1e-12, 1e-12));
  EXPECT_EQ(sensor::ClassifyBeam(scan, scan.ranges[4]), sensor::BeamKind::kNoReturn);
}

TEST(CarmenParser, LeavesOutOdometryWhenAsked) {
  LogOptions options;
  options.odometry = false;
  const ReadLog log = ReadAll(testing::ProjectData("logs/small.clf"), options);
  EXPECT_EQ(log.entries.size(), 7U);
  EXPECT_EQ(log.facts.entries, 7);
}

TEST(CarmenParser, SpreadsBeamsAsTheScannersDo) {
  const LogFiles files;
  const auto scan_of = [&](std::size_t beams) {
    const ReadLog log = ReadAll(files.Write("beams.log", FlaserLine(std::vector<std::string>(beams, "1.5"), "1", "1")));
    EXPECT_OK(log.status);
    return AllOf<sensor::LaserScan>(log).at(0);
  };
  const double degree = M_PI / 180.0;
  for (const std::size_t beams : {180U, 181U}) EXPECT_NEAR(scan_of(beams).angle_increment, degree, 1e-12);
  for (const std::size_t beams : {360U, 361U}) EXPECT_NEAR(scan_of(beams).angle_increment, 0.5 * degree, 1e-12);
  EXPECT_NEAR(scan_of(401).angle_increment, 0.25 * degree, 1e-12);
  EXPECT_NEAR(scan_of(401).angle_min, -50.0 * degree, 1e-12);
  EXPECT_EQ(scan_of(1).ranges.size(), 1U);
}

TEST(CarmenParser, KeepsUnknownAndInfiniteRanges) {
  const LogFiles files;
  const ReadLog log = ReadAll(files.Write("a.log", FlaserLine({"1.5", "nan", "-1", "inf", "0", "2.5"}, "1", "1")));
  ASSERT_OK(log.status);
  EXPECT_EQ(log.counts.beams_unknown, 3);
  EXPECT_EQ(log.counts.beams_no_return, 1);
}

struct BadLine {
  const char* name;
  std::string line;
  const char* message;
};

class CarmenBadLine : public ::testing::TestWithParam<BadLine> {};

TEST_P(CarmenBadLine, IsRefusedNamingFileLineAndField) {
  const LogFiles files;
  const std::string good = FlaserLine({"1", "2", "3"}, "1", "1");
  const auto path = files.Write("bad.log", good + GetParam().line + good);
  const ReadLog log = ReadAll(path);
  EXPECT_STATUS(log.status, absl::StatusCode::kInvalidArgument, HasSubstr(path.string() + ":2: "));
  EXPECT_STATUS(log.status, absl::StatusCode::kInvalidArgument, HasSubstr(GetParam().message));
  EXPECT_EQ(log.entries.size(), 2U) << "the bad line delivered a part";

  LogOptions skip;
  skip.skip_bad_lines = true;
  const ReadLog rest = ReadAll(path, skip);
  EXPECT_OK(rest.status);
  EXPECT_EQ(rest.entries.size(), 4U);
  EXPECT_EQ(rest.counts.bad_lines, 1);
}

INSTANTIATE_TEST_SUITE_P(
    All, CarmenBadLine,
    ::testing::Values(
        BadLine{"RangeMissing", "FLASER 4 1 2 3 0 0 0 1 2 0.5 1 host 1\n",
                "4 ranges are announced: the line needs 15 fields and has 14"},
        BadLine{"Truncated", "FLASER 3 1 2 3 0 0 0 1\n", "needs 14 fields and has 9"},
        BadLine{"RangeTooMany", "FLASER 2 1 2 3 0 0 0 1 2 0.5 1 host 1\n", "needs 13 fields and has 14"},
        BadLine{"OdometryTruncated", "ODOM 0 0 0 0 0\n", "the line ends before field 7 (accel)"},
        BadLine{"ZeroBeams", "FLASER 0 0 0 0 1 2 0.5 1 host 1\n", "is 0: expected 1 to 100000"},
        BadLine{"MillionBeams", "FLASER 1000000 1 2 3\n", "is 1000000: expected 1 to 100000"},
        BadLine{"NegativeCount", "FLASER -7 1 2 3\n", "is -7"},
        BadLine{"NotANumber", "FLASER 3 1 2x 3 0 0 0 1 2 0.5 1 host 1\n", "field 4 (range 2 of 3) is \"2x\""},
        BadLine{"NanPose", "FLASER 3 1 2 3 0 0 0 1 nan 0.5 1 host 1\n", "(odometry.y) is nan"},
        BadLine{"InfiniteTime", "ODOM 0 0 0 0 0 0 inf host 1\n", "(ipc_timestamp) is \"inf\": expected seconds"},
        BadLine{"HugeTime", "ODOM 0 0 0 0 0 0 99999999999 host 1\n", "ipc_timestamp"},
        BadLine{"Binary", std::string("FLASER 3 \x01\x02\0 1 2\n", 17), "binary data (byte 0x01 at column 10)"},
        BadLine{"RobotLaserTooManyBeams", "ROBOTLASER1 0 -1 2 0.1 50 0 0 200000 1\n", "200000"},
        BadLine{"RobotLaserZeroIncrement", "ROBOTLASER1 0 -1 2 0 50 0 0 2 1 1 0 0 0 0 0 0 0 0 0 0 0 0 2 host 2\n",
                "angle_increment is 0"}),
    [](const auto& param) { return param.param.name; });

}  // namespace
}  // namespace enfilade::sources
