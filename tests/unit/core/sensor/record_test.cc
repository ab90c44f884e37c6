// SPDX-License-Identifier: Apache-2.0
#include "core/sensor/record.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "core/sensor/session_entry.h"
#include "tests/support/status_assertions.h"

namespace enfilade::sensor {
namespace {

using ::testing::HasSubstr;

constexpr TimeNs kNow = 1'750'000'000 * kNsPerSecond;

BlobRef ValidBlob() { return {std::string(32, 'x'), 1}; }

DoorReport ValidReport() {
  DoorReport report;
  report.time = kNow;
  report.door_time = kNow - kNsPerSecond;
  report.width = 0.9;
  return report;
}

TEST(Record, KindsHaveTheStoredNumbers) {
  // The numbers are in databases and spools.
  const std::vector<std::pair<RecordPayload, int>> kinds = {{LaserScan(), 1},  {Odometry(), 2}, {Image(), 3},
                                                            {PointCloud(), 4}, {Withheld(), 5}, {DoorReport(), 6}};
  for (const auto& [payload, number] : kinds) EXPECT_EQ(static_cast<int>(KindOf({1, payload})), number);
}

TEST(Record, TakesTheTimeOfItsPayload) {
  LaserScan scan;
  scan.time = 1;
  EXPECT_EQ(TimeOf(RecordPayload(scan)), 1);
  EXPECT_EQ(TimeOf(RecordPayload(Odometry{2, {}})), 2);
  EXPECT_EQ(TimeOf(RecordPayload(Image{.time = 3, .content = ValidBlob()})), 3);
  EXPECT_EQ(TimeOf(RecordPayload(PointCloud{.time = 4, .content = ValidBlob()})), 4);
  DoorReport report;
  report.time = 5;
  EXPECT_EQ(TimeOf(RecordPayload(report)), 5);
  EXPECT_EQ(TimeOf(RecordPayload(Withheld{"lost"})), 0);
}

TEST(Record, OnlyImagesAndCloudsHaveBlobs) {
  const RecordPayload image = Image{.time = 1, .content = ValidBlob()};
  const RecordPayload cloud = PointCloud{.time = 1, .content = ValidBlob()};
  ASSERT_NE(FindBlob(image), nullptr);
  EXPECT_EQ(*FindBlob(image), ValidBlob());
  ASSERT_NE(FindBlob(cloud), nullptr);
  EXPECT_EQ(FindBlob(RecordPayload(Odometry())), nullptr);
  EXPECT_EQ(FindBlob(RecordPayload(DoorReport())), nullptr);
}

TEST(Record, AcceptsValidPayloads) {
  EXPECT_OK(Validate(Record{1, Odometry{kNow, {1.0, 2.0, 3.0}}}));
  EXPECT_OK(Validate(Record{1, Odometry{0, {}}}));
  EXPECT_OK(Validate(Record{INT64_MAX, Image{.time = kNow, .content = ValidBlob()}}));
  EXPECT_OK(Validate(Record{1, PointCloud{.time = kNow, .content = {std::string(32, '\0'), kMaxBlobBytes}}}));
  EXPECT_OK(Validate(Record{1, Withheld{std::string(4096, 'r')}}));
  EXPECT_OK(Validate(Record{1, ValidReport()}));
}

struct BadRecord {
  Record record;
  const char* message;
};

void PrintTo(const BadRecord& bad, std::ostream* os) { *os << bad.message; }

DoorReport ReportWith(const std::function<void(DoorReport&)>& change) {
  DoorReport report = ValidReport();
  change(report);
  return report;
}

class RefusedRecord : public ::testing::TestWithParam<BadRecord> {};
INSTANTIATE_TEST_SUITE_P(
    Record, RefusedRecord,
    ::testing::Values(
        BadRecord{{0, Odometry{kNow, {}}}, "sequence is 0"}, BadRecord{{-7, Odometry{kNow, {}}}, "sequence is -7"},
        BadRecord{{1, Odometry{-1, {}}}, "between 1970 and 2200"},
        BadRecord{{1, Odometry{7'258'118'400LL * kNsPerSecond, {}}}, "between 1970 and 2200"},
        BadRecord{{1, Odometry{kNow, {std::nan(""), 0, 0}}}, "odometry.pose (nan"},
        BadRecord{{1, Odometry{kNow, {0, 0, std::numeric_limits<double>::infinity()}}}, "odometry.pose (0, 0, inf"},
        BadRecord{{1, LaserScan()}, "laser_scan.ranges"},
        BadRecord{{1, Image{.time = kNow, .content = {std::string(31, 'x'), 1}}}, "31 bytes: expected 32"},
        BadRecord{{1, Image{.time = kNow, .content = {std::string(32, 'x'), 0}}}, "size_bytes is 0"},
        BadRecord{{1, PointCloud{.time = kNow, .content = {std::string(32, 'x'), kMaxBlobBytes + 1}}}, "size_bytes is"},
        BadRecord{{1, PointCloud{.time = kNow, .content = {"", 1}}}, "0 bytes: expected 32"},
        BadRecord{{1, Withheld{std::string(4097, 'r')}}, "withheld.reason has 4097 bytes"},
        BadRecord{{1, ReportWith([](DoorReport& r) { r.door_time = kNow + 2 * kNsPerSecond; })}, "2 s after its time"},
        BadRecord{{1, ReportWith([](DoorReport& r) { r.door_time = -1; })}, "between 1970 and 2200"},
        BadRecord{{1, ReportWith([](DoorReport& r) { r.level_time = kNow + 3 * kNsPerSecond; })}, "3 s after its time"},
        BadRecord{{1, ReportWith([](DoorReport& r) { r.level_time = -1; })}, "between 1970 and 2200"},
        BadRecord{{1, ReportWith([](DoorReport& r) { r.T_odom_door.yaw = NAN; })}, "pose_odom_door"},
        BadRecord{{1, ReportWith([](DoorReport& r) {
                     r.T_odom_gap = Pose2{0.0, NAN, 0.0};
                   })},
                  "pose_odom_gap"},
        BadRecord{{1, ReportWith([](DoorReport& r) { r.width = -0.1; })}, "width_m is -0.1"},
        BadRecord{{1, ReportWith([](DoorReport& r) { r.width = 1000.0; })}, "width_m is 1000"},
        BadRecord{{1, ReportWith([](DoorReport& r) { r.width = NAN; })}, "width_m is nan"},
        BadRecord{{1, ReportWith([](DoorReport& r) { r.reason.assign(5000, 'x'); })}, "door_report.reason"}));

TEST_P(RefusedRecord, NamesTheField) {
  EXPECT_STATUS(Validate(GetParam().record), absl::StatusCode::kInvalidArgument, HasSubstr(GetParam().message));
}

SessionEntry FullEntry() {
  SessionEntry entry;
  entry.previous = SessionId("s1");
  entry.T_map_robot =
      PoseWithCovariance{{1.0 / 3.0, -0.0, 3.0}, Eigen::Vector3d(0.1, 0.2, 0.3).asDiagonal().toDenseMatrix()};
  entry.T_odom_robot = Pose2{7.0, 8.0, -1.0};
  return entry;
}

bool Equal(const SessionEntry& a, const SessionEntry& b) {
  if (a.previous != b.previous || a.T_odom_robot != b.T_odom_robot) return false;
  if (a.T_map_robot.has_value() != b.T_map_robot.has_value()) return false;
  return !a.T_map_robot ||
         (a.T_map_robot->pose == b.T_map_robot->pose && a.T_map_robot->covariance == b.T_map_robot->covariance);
}

TEST(SessionEntryCodec, RestoresEveryCombinationOfFields) {
  for (int set = 0; set < 8; ++set) {
    SessionEntry entry = FullEntry();
    if ((set & 1) == 0) entry.previous.reset();
    if ((set & 2) == 0) entry.T_map_robot.reset();
    if ((set & 4) == 0) entry.T_odom_robot.reset();
    const std::string bytes = Encode(entry);
    EXPECT_EQ(bytes.empty(), set == 0);
    ASSERT_OK_AND_ASSIGN(const SessionEntry decoded, DecodeSessionEntry(bytes));
    EXPECT_TRUE(Equal(decoded, entry)) << set;
  }
}

TEST(SessionEntryCodec, RefusesDamagedBytes) {
  const std::string bytes = Encode(FullEntry());
  for (std::size_t size = 1; size < bytes.size(); ++size) {
    EXPECT_CODE(DecodeSessionEntry(std::string_view(bytes).substr(0, size)), absl::StatusCode::kDataLoss) << size;
  }
  EXPECT_CODE(DecodeSessionEntry(bytes + '\0'), absl::StatusCode::kDataLoss);
  std::string newer = bytes;
  newer[0] = 2;
  EXPECT_STATUS(DecodeSessionEntry(newer), absl::StatusCode::kDataLoss, HasSubstr("version 2"));
  std::string huge_name = bytes;
  huge_name[1 + 7] = '\x7f';  // the top byte of the name's length
  EXPECT_CODE(DecodeSessionEntry(huge_name), absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace enfilade::sensor
