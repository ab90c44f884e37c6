// SPDX-License-Identifier: Apache-2.0
#include "proto/convert/record.h"

#include <utility>

#include "core/base/environment.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::convert {
namespace {

v1::BlobRef BlobToProto(const sensor::BlobRef& blob) {
  v1::BlobRef out;
  out.set_sha256(blob.sha256);
  out.set_size_bytes(blob.size);
  return out;
}

struct PayloadToProto {
  v1::Record& out;

  void operator()(const sensor::LaserScan& scan) const { enfilade::convert::ToProto(scan, *out.mutable_laser_scan()); }
  void operator()(const sensor::Odometry& odometry) const {
    *out.mutable_odometry()->mutable_time() = ToTimestamp(odometry.time);
    *out.mutable_odometry()->mutable_pose_odom_robot() = enfilade::convert::ToProto(odometry.T_odom_robot);
  }
  void operator()(const sensor::Image& image) const {
    *out.mutable_image()->mutable_time() = ToTimestamp(image.time);
    out.mutable_image()->set_camera(static_cast<v1::Image::Camera>(image.camera));
    out.mutable_image()->set_encoding(static_cast<v1::Image::Encoding>(image.encoding));
    *out.mutable_image()->mutable_content() = BlobToProto(image.content);
  }
  void operator()(const sensor::PointCloud& cloud) const {
    *out.mutable_point_cloud()->mutable_time() = ToTimestamp(cloud.time);
    out.mutable_point_cloud()->set_encoding(static_cast<v1::PointCloud::Encoding>(cloud.encoding));
    *out.mutable_point_cloud()->mutable_content() = BlobToProto(cloud.content);
  }
  void operator()(const sensor::Withheld& withheld) const { out.mutable_withheld()->set_reason(withheld.reason); }
  void operator()(const sensor::DoorReport& report) const {
    v1::DoorReport& door = *out.mutable_door_report();
    *door.mutable_time() = ToTimestamp(report.time);
    door.set_kind(static_cast<v1::DoorReport::Kind>(report.kind));
    door.set_place(static_cast<v1::DoorReport::Place>(report.place));
    *door.mutable_door_time() = ToTimestamp(report.door_time);
    *door.mutable_pose_odom_door() = enfilade::convert::ToProto(report.T_odom_door);
    door.set_width_m(report.width);
    door.set_entered_surroundings(
        static_cast<v1::DoorReport::Surroundings>(report.entered_environment.value_or(Environment{})));
    if (report.entered_level) door.set_entered_level(*report.entered_level);
    door.set_by_hand(report.by_hand);
    door.set_reason(report.reason);
    if (report.level_time) *door.mutable_level_time() = ToTimestamp(*report.level_time);
    if (report.T_odom_gap) *door.mutable_pose_odom_gap() = enfilade::convert::ToProto(*report.T_odom_gap);
  }
};

// The core enums number their values as the wire does.
static_assert(static_cast<int>(sensor::Camera::kRear) == v1::Image::CAMERA_REAR);
static_assert(static_cast<int>(sensor::ImageEncoding::kDepthPng16) == v1::Image::ENCODING_DEPTH_PNG16);
static_assert(static_cast<int>(sensor::CloudEncoding::kXyz32) == v1::PointCloud::ENCODING_XYZ32);
static_assert(static_cast<int>(sensor::DoorReport::Kind::kPassage) == v1::DoorReport::KIND_PASSAGE);
static_assert(static_cast<int>(graph::LinkPointKind::kOpening) == v1::DoorReport::PLACE_OPENING);
static_assert(static_cast<int>(Environment::kOutdoor) == v1::DoorReport::SURROUNDINGS_OUTDOOR);

// A value that this program knows, and not the unspecified one; `known` is the generated _IsValid.
template <typename Core, typename Wire>
absl::StatusOr<Core> FromEnum(const char* field, Wire value, bool (*known)(int)) {
  if (static_cast<int>(value) == 0) return InvalidArgument("{} is not set", field);
  if (!known(value)) return InvalidArgument("{} is {}: unknown to this server", field, static_cast<int>(value));
  return static_cast<Core>(value);
}

absl::StatusOr<sensor::LaserScan> ScanFromProto(const v1::LaserScan& in) {
  sensor::LaserScan scan;
  ENFILADE_ASSIGN_OR_RETURN(scan.time, FromTimestamp(in.time()));
  scan.angle_min = in.angle_min_rad();
  scan.angle_increment = in.angle_increment_rad();
  scan.time_increment = in.time_increment_s();
  scan.range_min = in.range_min_m();
  scan.range_max = in.range_max_m();
  scan.T_robot_laser = FromProto(in.pose_robot_laser());
  scan.ranges.assign(in.ranges_m().begin(), in.ranges_m().end());
  return scan;
}

absl::StatusOr<sensor::Odometry> OdometryFromProto(const v1::Odometry& in) {
  sensor::Odometry odometry;
  if (!in.has_pose_odom_robot()) return InvalidArgument("odometry.pose_odom_robot is not set");
  ENFILADE_ASSIGN_OR_RETURN(odometry.time, FromTimestamp(in.time()));
  odometry.T_odom_robot = FromProto(in.pose_odom_robot());
  return odometry;
}

absl::StatusOr<sensor::Image> ImageFromProto(const v1::Image& in) {
  sensor::Image image;
  ENFILADE_ASSIGN_OR_RETURN(image.time, FromTimestamp(in.time()));
  ENFILADE_ASSIGN_OR_RETURN(image.camera,
                            FromEnum<sensor::Camera>("image.camera", in.camera(), v1::Image::Camera_IsValid));
  ENFILADE_ASSIGN_OR_RETURN(
      image.encoding, FromEnum<sensor::ImageEncoding>("image.encoding", in.encoding(), v1::Image::Encoding_IsValid));
  image.content = {in.content().sha256(), in.content().size_bytes()};
  return image;
}

absl::StatusOr<sensor::PointCloud> CloudFromProto(const v1::PointCloud& in) {
  sensor::PointCloud cloud;
  ENFILADE_ASSIGN_OR_RETURN(cloud.time, FromTimestamp(in.time()));
  ENFILADE_ASSIGN_OR_RETURN(cloud.encoding, FromEnum<sensor::CloudEncoding>("point_cloud.encoding", in.encoding(),
                                                                            v1::PointCloud::Encoding_IsValid));
  cloud.content = {in.content().sha256(), in.content().size_bytes()};
  return cloud;
}

absl::StatusOr<sensor::DoorReport> DoorReportFromProto(const v1::DoorReport& in) {
  sensor::DoorReport report;
  if (!in.has_pose_odom_door()) return InvalidArgument("door_report.pose_odom_door is not set");
  ENFILADE_ASSIGN_OR_RETURN(report.time, FromTimestamp(in.time()));
  ENFILADE_ASSIGN_OR_RETURN(
      report.kind, FromEnum<sensor::DoorReport::Kind>("door_report.kind", in.kind(), v1::DoorReport::Kind_IsValid));
  if (in.place() != v1::DoorReport::PLACE_UNSPECIFIED) {
    ENFILADE_ASSIGN_OR_RETURN(
        report.place, FromEnum<graph::LinkPointKind>("door_report.place", in.place(), v1::DoorReport::Place_IsValid));
  }
  ENFILADE_ASSIGN_OR_RETURN(report.door_time, FromTimestamp(in.door_time()));
  report.T_odom_door = FromProto(in.pose_odom_door());
  report.width = in.width_m();
  if (in.entered_surroundings() != v1::DoorReport::SURROUNDINGS_UNSPECIFIED) {
    ENFILADE_ASSIGN_OR_RETURN(report.entered_environment,
                              FromEnum<Environment>("door_report.entered_surroundings", in.entered_surroundings(),
                                                    v1::DoorReport::Surroundings_IsValid));
  }
  if (in.has_entered_level()) report.entered_level = in.entered_level();
  report.by_hand = in.by_hand();
  report.reason = in.reason();
  if (in.has_level_time()) {
    ENFILADE_ASSIGN_OR_RETURN(report.level_time, FromTimestamp(in.level_time()));
  }
  if (in.has_pose_odom_gap()) report.T_odom_gap = FromProto(in.pose_odom_gap());
  return report;
}

absl::StatusOr<sensor::Record> PayloadFromProto(const v1::Record& in) {
  sensor::Record record;
  record.sequence = in.sequence();
  switch (in.payload_case()) {
    case v1::Record::kLaserScan: {
      ENFILADE_ASSIGN_OR_RETURN(record.payload, ScanFromProto(in.laser_scan()));
      return record;
    }
    case v1::Record::kOdometry: {
      ENFILADE_ASSIGN_OR_RETURN(record.payload, OdometryFromProto(in.odometry()));
      return record;
    }
    case v1::Record::kImage: {
      ENFILADE_ASSIGN_OR_RETURN(record.payload, ImageFromProto(in.image()));
      return record;
    }
    case v1::Record::kPointCloud: {
      ENFILADE_ASSIGN_OR_RETURN(record.payload, CloudFromProto(in.point_cloud()));
      return record;
    }
    case v1::Record::kWithheld:
      record.payload = sensor::Withheld{in.withheld().reason()};
      return record;
    case v1::Record::kDoorReport: {
      ENFILADE_ASSIGN_OR_RETURN(record.payload, DoorReportFromProto(in.door_report()));
      return record;
    }
    case v1::Record::PAYLOAD_NOT_SET:
      break;
  }
  return InvalidArgument("payload is not set, or of a kind unknown to this server");
}

}  // namespace

v1::Pose2 ToProto(const Pose2& pose) {
  v1::Pose2 out;
  out.set_x(pose.x);
  out.set_y(pose.y);
  out.set_yaw(pose.yaw);
  return out;
}

Pose2 FromProto(const v1::Pose2& pose) { return {pose.x(), pose.y(), pose.yaw()}; }

google::protobuf::Timestamp ToTimestamp(TimeNs time) {
  google::protobuf::Timestamp out;
  out.set_seconds(time / kNsPerSecond);
  out.set_nanos(static_cast<std::int32_t>(time % kNsPerSecond));
  return out;
}

absl::StatusOr<TimeNs> FromTimestamp(const google::protobuf::Timestamp& time) {
  constexpr std::int64_t kYear2200 = 7'258'118'400LL;
  if (time.seconds() < 0 || time.seconds() >= kYear2200 || time.nanos() < 0 || time.nanos() >= kNsPerSecond) {
    return InvalidArgument("time is {} s and {} ns since 1970: expected a time between 1970 and 2200", time.seconds(),
                           time.nanos());
  }
  return time.seconds() * kNsPerSecond + time.nanos();
}

void ToProto(const sensor::LaserScan& scan, v1::LaserScan& out) {
  *out.mutable_time() = ToTimestamp(scan.time);
  out.set_angle_min_rad(scan.angle_min);
  out.set_angle_increment_rad(scan.angle_increment);
  out.set_time_increment_s(scan.time_increment);
  out.set_range_min_m(scan.range_min);
  out.set_range_max_m(scan.range_max);
  if (scan.T_robot_laser != Pose2{}) *out.mutable_pose_robot_laser() = ToProto(scan.T_robot_laser);
  out.mutable_ranges_m()->Add(scan.ranges.begin(), scan.ranges.end());
}

v1::Record ToProto(const sensor::Record& record) {
  v1::Record out;
  out.set_sequence(record.sequence);
  std::visit(PayloadToProto{out}, record.payload);
  return out;
}

absl::StatusOr<sensor::Record> FromProto(const v1::Record& in) {
  ENFILADE_ASSIGN_OR_RETURN(sensor::Record record, PayloadFromProto(in));
  ENFILADE_RETURN_IF_ERROR(sensor::Validate(record));
  return record;
}

}  // namespace enfilade::convert
