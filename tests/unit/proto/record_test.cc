// SPDX-License-Identifier: Apache-2.0
#include "proto/convert/record.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/base/environment.h"
#include "tests/support/status_assertions.h"

namespace enfilade::convert {
namespace {

using ::testing::HasSubstr;

sensor::Record ScanRecord() {
  sensor::LaserScan scan;
  scan.time = 976'052'858'304'357'001;
  scan.angle_min = -M_PI / 2.0;
  scan.angle_increment = M_PI / 180.0;
  scan.range_max = 81.83F;
  scan.T_robot_laser = {0.1, -0.2, 0.3};
  scan.ranges = {1.07F, -1.0F, std::numeric_limits<float>::infinity(), 81.83F};
  return {1, scan};
}

TEST(ConvertRecord, RoundTripsEveryKindExactly) {
  const sensor::BlobRef blob{std::string(32, '\x01'), 5};
  for (const sensor::Record& record :
       {ScanRecord(), sensor::Record{2, sensor::Odometry{5, {1.0 / 3.0, 2.0, M_PI}}},
        sensor::Record{3, sensor::Image{7, sensor::Camera::kRear, sensor::ImageEncoding::kJpeg, blob}},
        sensor::Record{4, sensor::PointCloud{9, sensor::CloudEncoding::kXyz32, blob}},
        sensor::Record{5, sensor::Withheld{"why"}},
        sensor::Record{6, sensor::DoorReport{9,
                                             sensor::DoorReport::Kind::kPassage,
                                             graph::LinkPointKind::kLift,
                                             7,
                                             {1, -2, 0.5},
                                             0.9,
                                             Environment::kOutdoor,
                                             -1,
                                             true,
                                             "by hand",
                                             3,
                                             Pose2{2.0, -1.5, 0.25}}},
        sensor::Record{7, sensor::DoorReport()}}) {
    v1::Record received;
    ASSERT_TRUE(received.ParseFromString(ToProto(record).SerializeAsString()));
    ASSERT_OK_AND_ASSIGN(const sensor::Record converted, FromProto(received));
    EXPECT_EQ(converted, record) << record.sequence;
  }
}

void ExpectRefused(void (*change)(v1::Record&), const char* field) {
  v1::Record record = ToProto(sensor::Record{
      3, sensor::Image{7, sensor::Camera::kRear, sensor::ImageEncoding::kJpeg, {std::string(32, 'x'), 5}}});
  change(record);
  EXPECT_STATUS(FromProto(record), absl::StatusCode::kInvalidArgument, HasSubstr(field));
}

TEST(ConvertRecord, RefusesWhatIsUnsetOrUnknownNamingTheField) {
  ExpectRefused([](v1::Record& r) { r.clear_payload(); }, "payload is not set");
  ExpectRefused([](v1::Record& r) { r.set_sequence(0); }, "sequence");
  ExpectRefused([](v1::Record& r) { r.mutable_image()->clear_camera(); }, "image.camera is not set");
  ExpectRefused([](v1::Record& r) { r.mutable_image()->set_camera(static_cast<v1::Image::Camera>(99)); },
                "image.camera is 99");
  ExpectRefused([](v1::Record& r) { r.mutable_image()->mutable_content()->set_sha256("short"); }, "sha256");
  ExpectRefused([](v1::Record& r) { r.mutable_image()->mutable_content()->set_size_bytes(65LL << 20); }, "size_bytes");
  ExpectRefused([](v1::Record& r) { r.mutable_image()->mutable_time()->set_seconds(-5); }, "time");
  ExpectRefused([](v1::Record& r) { r.mutable_odometry(); }, "pose_odom_robot is not set");
  ExpectRefused([](v1::Record& r) { r.mutable_odometry()->mutable_pose_odom_robot()->set_x(NAN); }, "odometry.pose");
  ExpectRefused([](v1::Record& r) { r.mutable_laser_scan(); }, "ranges is empty");
}

TEST(ConvertRecord, RefusesBadDoorReportsNamingTheField) {
  const auto expect_refused = [](void (*change)(v1::DoorReport&), const char* field) {
    v1::Record record = ToProto(sensor::Record{1, sensor::DoorReport()});
    change(*record.mutable_door_report());
    EXPECT_STATUS(FromProto(record), absl::StatusCode::kInvalidArgument, HasSubstr(field));
  };
  expect_refused([](v1::DoorReport& r) { r.clear_kind(); }, "door_report.kind is not set");
  expect_refused([](v1::DoorReport& r) { r.set_place(static_cast<v1::DoorReport::Place>(9)); }, "door_report.place");
  expect_refused([](v1::DoorReport& r) { r.clear_pose_odom_door(); }, "pose_odom_door is not set");
  expect_refused([](v1::DoorReport& r) { r.mutable_pose_odom_door()->set_yaw(NAN); }, "pose_odom_door is not finite");
  expect_refused([](v1::DoorReport& r) { r.mutable_pose_odom_gap()->set_x(NAN); }, "pose_odom_gap is not finite");
  expect_refused([](v1::DoorReport& r) { r.mutable_door_time()->set_nanos(10); }, "door_time");
  expect_refused([](v1::DoorReport& r) { r.mutable_level_time()->set_nanos(10); }, "level_time");
  expect_refused([](v1::DoorReport& r) { r.set_width_m(-1.0); }, "width_m");
  expect_refused([](v1::DoorReport& r) { r.set_reason(std::string(5000, 'x')); }, "reason");
}

TEST(ConvertRecord, TakesARecordOfAKindFromTheFutureAsUnset) {
  v1::Record record;
  // Field 15, as a newer client's payload would arrive.
  ASSERT_TRUE(record.ParseFromString(std::string("\x08\x01\x7a\x02hi", 6)));
  EXPECT_STATUS(FromProto(record), absl::StatusCode::kInvalidArgument, HasSubstr("unknown to this server"));
}

}  // namespace
}  // namespace enfilade::convert
