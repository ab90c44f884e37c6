// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "client/sources/content.h"
#include "client/sources/formats/json_lines_writer.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/client/sources/log_files.h"

namespace enfilade::sources {
namespace {

using sources::LogEntry;
using testing::AllOf;
using ::testing::HasSubstr;
using testing::LogFiles;
using testing::ReadAll;
using testing::ReadLog;

constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;

TEST(JsonLines, ReadsTheDocumentedExample) {
  const ReadLog log = ReadAll(testing::ProjectData("logs/small.jsonl"));
  ASSERT_OK(log.status);
  ASSERT_EQ(log.entries.size(), 2U);
  EXPECT_EQ(log.facts.entries, 2);
  EXPECT_EQ(log.facts.scans, 1);
  const auto odometry = AllOf<sensor::Odometry>(log).at(0);
  EXPECT_EQ(odometry.time, 1'700'000'000'000'000'001);
  EXPECT_EQ(odometry.T_odom_robot, (Pose2{1.5, -2.0, 0.1}));
  const auto scan = AllOf<sensor::LaserScan>(log).at(0);
  EXPECT_EQ(scan.T_robot_laser, (Pose2{0.2, 0.0, 3.1}));
  EXPECT_EQ(scan.range_max, 10.0F);
  EXPECT_EQ(scan.ranges[0], 1.07F);
  EXPECT_TRUE(std::isnan(scan.ranges[1]));
  EXPECT_EQ(scan.ranges[2], std::numeric_limits<float>::infinity());
  EXPECT_EQ(log.counts.beams_no_return, 2);
  EXPECT_EQ(log.counts.beams_unknown, 2);
}

TEST(JsonLines, WritingAndReadingBackKeepsEveryBit) {
  std::mt19937 random(7);
  std::uniform_int_distribution<std::uint32_t> bits;
  sensor::LaserScan scan;
  scan.time = 1'700'000'000'123'456'789;
  scan.angle_min = -M_PI / 3.0;
  scan.angle_increment = 0.1 + 0.2;
  scan.time_increment = 1.0 / 3.0;
  scan.range_min = 0.1F;
  scan.range_max = 81.83F;
  scan.T_robot_laser = {0.1, -1e-300, 1.0 / 7.0};
  for (int i = 0; i < 5000; ++i) {
    const std::uint32_t pattern = bits(random);
    float range = 0.0F;
    std::memcpy(&range, &pattern, sizeof(range));
    if (!std::isnan(range)) scan.ranges.push_back(range);
  }
  const sensor::Odometry odometry{42, {1e17 + 2.0, -0.0, M_PI}};
  std::string text = sources::JsonLinesHeader();
  for (const LogEntry& entry : {LogEntry{odometry, {}}, LogEntry{scan, {}}}) {
    ASSERT_OK_AND_ASSIGN(const std::string line, sources::ToJsonLine(entry));
    text += line;
  }
  const LogFiles files;
  const ReadLog log = ReadAll(files.Write("a.jsonl", text));
  ASSERT_OK(log.status);
  ASSERT_EQ(log.entries.size(), 2U);
  EXPECT_EQ(std::get<sensor::Odometry>(log.entries[0].payload), odometry);
  EXPECT_TRUE(std::signbit(std::get<sensor::Odometry>(log.entries[0].payload).T_odom_robot.y));
  EXPECT_EQ(std::get<sensor::LaserScan>(log.entries[1].payload), scan);
}

TEST(JsonLines, RefersToImagesAndCloudsByFile) {
  const LogFiles files;
  files.Write("it's a \"door\".png", "not really a PNG");
  files.Write("door.xyz", std::string(24, '\0'));
  std::string text;
  for (const LogEntry& entry :
       {LogEntry{sensor::Image{7, sensor::Camera::kRear, sensor::ImageEncoding::kPng, {}}, "it's a \"door\".png"},
        LogEntry{sensor::PointCloud{8, sensor::CloudEncoding::kXyz32, {}}, "door.xyz"}}) {
    ASSERT_OK_AND_ASSIGN(const std::string line, sources::ToJsonLine(entry));
    text += line;
  }
  const ReadLog log = ReadAll(files.Write("a.jsonl", text));
  ASSERT_OK(log.status);
  const sensor::Image image = AllOf<sensor::Image>(log).at(0);
  EXPECT_EQ(image.camera, sensor::Camera::kRear);
  EXPECT_EQ(image.content, sources::RefOf("not really a PNG"));
  EXPECT_EQ(log.entries[0].content, files.path() / "it's a \"door\".png");
  EXPECT_EQ(AllOf<sensor::PointCloud>(log).at(0).content.size, 24);
}

struct BadJsonLine {
  const char* name;
  const char* line;
  const char* message;
};

class JsonBadLine : public ::testing::TestWithParam<BadJsonLine> {};

TEST_P(JsonBadLine, IsRefusedNamingFileLineAndMember) {
  const LogFiles files;
  const auto path =
      files.Write("bad.jsonl", "{\"type\":\"log\",\"version\":1}\n" + std::string(GetParam().line) + "\n");
  const ReadLog log = ReadAll(path);
  EXPECT_STATUS(log.status, kInvalid, HasSubstr(path.string() + ":2: "));
  EXPECT_STATUS(log.status, kInvalid, HasSubstr(GetParam().message));
  EXPECT_TRUE(log.entries.empty());
}

#define SCAN(rest) R"({"type":"scan","time_ns":1,"angle_min_rad":0,"angle_increment_rad":0.1,"range_min_m":0,)" rest "}"

INSTANTIATE_TEST_SUITE_P(
    All, JsonBadLine,
    ::testing::Values(
        BadJsonLine{"Cut", R"({"type":"scan","time_ns":1,"angle_)", "not valid JSON"},
        BadJsonLine{"NoObject", "[1,2]", "expected a JSON object"}, BadJsonLine{"NoType", "{}", "type is missing"},
        BadJsonLine{"UnknownType", R"({"type":"sonar"})", "type is \"sonar\""},
        BadJsonLine{"NewerVersion", R"({"type":"log","version":2})", "version is 2"},
        BadJsonLine{"NoRanges", SCAN(R"("range_max_m":10)"), "ranges_m is missing"},
        BadJsonLine{"ZeroBeams", SCAN(R"("range_max_m":10,"ranges_m":[])"), "ranges is empty"},
        BadJsonLine{"RangeText", SCAN(R"("range_max_m":10,"ranges_m":[1,"far"])"), "ranges_m[1] is \"far\""},
        BadJsonLine{"RangeArray", SCAN(R"("range_max_m":10,"ranges_m":[1,[2]])"), "ranges_m[1] is an array"},
        BadJsonLine{"Misspelt", SCAN(R"("range_max_m":10,"ranges_m":[1],"mounted":1)"), "unknown members"},
        BadJsonLine{"NoLimit", SCAN(R"("range_max_m":0,"ranges_m":[1])"), "range limits"},
        BadJsonLine{"HalfAPose", R"({"type":"odometry","time_ns":1,"pose":{"x_m":1,"y_m":2}})",
                    "pose.yaw_rad is missing"},
        BadJsonLine{"FractionalTime", R"({"type":"odometry","time_ns":1.5,"pose":{"x_m":1,"y_m":2,"yaw_rad":0}})",
                    "time_ns is 1.5: expected an integer"},
        BadJsonLine{"NegativeTime", R"({"type":"odometry","time_ns":-1,"pose":{"x_m":1,"y_m":2,"yaw_rad":0}})",
                    "time is"},
        BadJsonLine{"NoSuchImage", R"({"type":"image","time_ns":1,"camera":"rear","encoding":"png","file":"no.png"})",
                    "no such file"},
        BadJsonLine{"UnknownCamera", R"({"type":"image","time_ns":1,"camera":"side","encoding":"png","file":"no.png"})",
                    "camera is \"side\""}),
    [](const auto& param) { return param.param.name; });

// What a log cannot hold is refused when it is written, so that no reader meets it.
TEST(JsonLines, RefusesToWriteWhatALogCannotHold) {
  const auto written = [](sensor::RecordPayload payload) {
    return sources::ToJsonLine(LogEntry{std::move(payload), {}}).status();
  };
  sensor::LaserScan scan;
  scan.ranges = {1.0F};
  scan.time = 17;
  EXPECT_OK(written(scan));
  for (double sensor::LaserScan::*member :
       {&sensor::LaserScan::angle_min, &sensor::LaserScan::angle_increment, &sensor::LaserScan::time_increment}) {
    sensor::LaserScan bad = scan;
    bad.*member = std::numeric_limits<double>::infinity();
    EXPECT_STATUS(written(bad), kInvalid, HasSubstr("the scan at 17 ns has a non-finite parameter"));
  }
  sensor::LaserScan bad = scan;
  bad.range_max = std::numeric_limits<float>::quiet_NaN();
  EXPECT_STATUS(written(bad), kInvalid, HasSubstr("non-finite parameter"));
  bad = scan;
  bad.T_robot_laser.yaw = NAN;
  EXPECT_STATUS(written(bad), kInvalid, HasSubstr("non-finite mount"));
  EXPECT_STATUS(written(sensor::Odometry{5, {NAN, 0.0, 0.0}}), kInvalid, HasSubstr("the odometry at 5 ns"));
  EXPECT_STATUS(written(sensor::DoorReport{}), kInvalid, HasSubstr("has no place in a log file"));
  sensor::Withheld withheld;
  withheld.reason = "damaged";
  EXPECT_STATUS(written(withheld), kInvalid, HasSubstr("\"damaged\""));
}

}  // namespace
}  // namespace enfilade::sources
