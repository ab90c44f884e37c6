// SPDX-License-Identifier: Apache-2.0
#include "core/sensor/record_codec.h"

#include "core/base/binary.h"
#include "core/base/error.h"
#include "core/geometry/pose_codec.h"

namespace enfilade::sensor {
namespace {

constexpr std::uint8_t kRecordVersion = 1;
// Door reports that end with level_time, and with T_odom_gap. Others keep the version that older programs know.
constexpr std::uint8_t kLevelTimeVersion = 2;
constexpr std::uint8_t kGapVersion = 3;

struct PayloadWriter {
  BinaryWriter& writer;

  void Put(const BlobRef& blob) const {
    writer.PutString(blob.sha256);
    writer.Put(blob.size);
  }

  void operator()(const LaserScan& scan) const {
    writer.Put(scan.time);
    writer.Put(scan.angle_min);
    writer.Put(scan.angle_increment);
    writer.Put(scan.time_increment);
    writer.Put(scan.range_min);
    writer.Put(scan.range_max);
    PutPose(writer, scan.T_robot_laser);
    writer.PutVector(scan.ranges);
  }
  void operator()(const Odometry& odometry) const {
    writer.Put(odometry.time);
    PutPose(writer, odometry.T_odom_robot);
  }
  void operator()(const Image& image) const {
    writer.Put(image.time);
    writer.Put(image.camera);
    writer.Put(image.encoding);
    Put(image.content);
  }
  void operator()(const PointCloud& cloud) const {
    writer.Put(cloud.time);
    writer.Put(cloud.encoding);
    Put(cloud.content);
  }
  void operator()(const Withheld& withheld) const { writer.PutString(withheld.reason); }
  void operator()(const DoorReport& report) const {
    writer.Put(report.time);
    writer.Put(report.kind);
    writer.Put(report.place);
    writer.Put(report.door_time);
    PutPose(writer, report.T_odom_door);
    writer.Put(report.width);
    writer.Put(report.entered_environment.value_or(Environment{}));
    writer.Put(report.entered_level.has_value());
    writer.Put(report.entered_level.value_or(0));
    writer.Put(report.by_hand);
    writer.PutString(report.reason);
    if (report.T_odom_gap) {
      writer.Put(report.level_time.has_value());
      writer.Put(report.level_time.value_or(0));
      PutPose(writer, *report.T_odom_gap);
    } else if (report.level_time) {
      writer.Put(*report.level_time);
    }
  }
};

BlobRef ReadBlob(BinaryReader& reader) {
  BlobRef blob;
  blob.sha256 = std::string(reader.GetString());
  blob.size = reader.Get<std::int64_t>();
  return blob;
}

LaserScan ReadLaserScan(BinaryReader& reader) {
  LaserScan scan;
  scan.time = reader.Get<TimeNs>();
  scan.angle_min = reader.Get<double>();
  scan.angle_increment = reader.Get<double>();
  scan.time_increment = reader.Get<double>();
  scan.range_min = reader.Get<float>();
  scan.range_max = reader.Get<float>();
  scan.T_robot_laser = GetPose(reader);
  scan.ranges = reader.GetVector<float>();
  return scan;
}

Odometry ReadOdometry(BinaryReader& reader) {
  Odometry odometry;
  odometry.time = reader.Get<TimeNs>();
  odometry.T_odom_robot = GetPose(reader);
  return odometry;
}

Image ReadImage(BinaryReader& reader) {
  Image image;
  image.time = reader.Get<TimeNs>();
  image.camera = reader.Get<Camera>();
  image.encoding = reader.Get<ImageEncoding>();
  image.content = ReadBlob(reader);
  return image;
}

PointCloud ReadPointCloud(BinaryReader& reader) {
  PointCloud cloud;
  cloud.time = reader.Get<TimeNs>();
  cloud.encoding = reader.Get<CloudEncoding>();
  cloud.content = ReadBlob(reader);
  return cloud;
}

DoorReport ReadDoorReport(BinaryReader& reader, std::uint8_t version) {
  DoorReport report;
  report.time = reader.Get<TimeNs>();
  report.kind = reader.Get<DoorReport::Kind>();
  report.place = reader.Get<graph::LinkPointKind>();
  report.door_time = reader.Get<TimeNs>();
  report.T_odom_door = GetPose(reader);
  report.width = reader.Get<double>();
  if (const auto entered = reader.Get<Environment>(); entered != Environment{}) report.entered_environment = entered;
  const auto has_level = reader.Get<bool>();
  const auto level = reader.Get<std::int32_t>();
  if (has_level) report.entered_level = level;
  report.by_hand = reader.Get<bool>();
  report.reason = std::string(reader.GetString());
  const bool has_level_time = version == kGapVersion ? reader.Get<bool>() : version == kLevelTimeVersion;
  if (version != kRecordVersion) {
    const auto level_time = reader.Get<TimeNs>();
    if (has_level_time) report.level_time = level_time;
  }
  if (version == kGapVersion) report.T_odom_gap = GetPose(reader);
  return report;
}

std::uint8_t VersionOf(const Record& record) {
  const auto* report = std::get_if<DoorReport>(&record.payload);
  if (report == nullptr) return kRecordVersion;
  return report->T_odom_gap ? kGapVersion : report->level_time ? kLevelTimeVersion : kRecordVersion;
}

bool IsKnown(std::uint8_t version, RecordKind kind) {
  if (version == kRecordVersion) return true;
  return kind == RecordKind::kDoorReport && (version == kLevelTimeVersion || version == kGapVersion);
}

}  // namespace

void AppendPayload(const Record& record, std::string& out) {
  BinaryWriter writer(out);
  writer.Put(VersionOf(record));
  std::visit(PayloadWriter{writer}, record.payload);
}

std::string EncodePayload(const Record& record) {
  std::string bytes;
  AppendPayload(record, bytes);
  return bytes;
}

absl::StatusOr<Record> DecodePayload(std::int64_t sequence, RecordKind kind, std::string_view bytes) {
  BinaryReader reader(bytes);
  const auto version = reader.Get<std::uint8_t>();
  if (!IsKnown(version, kind)) {
    return DataLoss("record {}: payload version {} is unknown to this program", sequence, version);
  }
  Record record;
  record.sequence = sequence;
  switch (kind) {
    case RecordKind::kLaserScan:
      record.payload = ReadLaserScan(reader);
      break;
    case RecordKind::kOdometry:
      record.payload = ReadOdometry(reader);
      break;
    case RecordKind::kImage:
      record.payload = ReadImage(reader);
      break;
    case RecordKind::kPointCloud:
      record.payload = ReadPointCloud(reader);
      break;
    case RecordKind::kWithheld:
      record.payload = Withheld{std::string(reader.GetString())};
      break;
    case RecordKind::kDoorReport:
      record.payload = ReadDoorReport(reader, version);
      break;
    default:
      return DataLoss("record {}: kind {} is unknown to this program", sequence, static_cast<int>(kind));
  }
  if (!reader.at_end()) {
    return DataLoss("record {}: payload of {} bytes is truncated or has trailing bytes", sequence, bytes.size());
  }
  return record;
}

}  // namespace enfilade::sensor
