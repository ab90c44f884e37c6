// SPDX-License-Identifier: Apache-2.0
#include "core/sensor/record.h"

#include "core/base/error.h"

namespace enfilade::sensor {
namespace {

constexpr std::size_t kMaxReasonBytes = 4096;

absl::Status ValidateReason(std::string_view field, std::string_view reason) {
  if (reason.size() <= kMaxReasonBytes) return absl::OkStatus();
  return InvalidArgument("{} has {} bytes, more than {}", field, reason.size(), kMaxReasonBytes);
}

absl::Status ValidateTime(TimeNs time) {
  constexpr TimeNs kYear2200 = 7'258'118'400LL * kNsPerSecond;
  if (time >= 0 && time < kYear2200) return absl::OkStatus();
  return InvalidArgument("time is {} s since 1970: expected between 1970 and 2200", ToSeconds(time));
}

absl::Status ValidateBlob(const BlobRef& blob) {
  if (blob.sha256.size() != 32) {
    return InvalidArgument("content.sha256 has {} bytes: expected 32", blob.sha256.size());
  }
  if (blob.size < 1 || blob.size > kMaxBlobBytes) {
    return InvalidArgument("content.size_bytes is {}: expected 1 to {}", blob.size, kMaxBlobBytes);
  }
  return absl::OkStatus();
}

struct PayloadCheck {
  absl::Status operator()(const LaserScan& scan) const { return Validate(scan); }
  absl::Status operator()(const Odometry& odometry) const {
    if (IsFinite(odometry.T_odom_robot)) return absl::OkStatus();
    return InvalidArgument("odometry.pose ({}, {}, {}) is not finite", odometry.T_odom_robot.x, odometry.T_odom_robot.y,
                           odometry.T_odom_robot.yaw);
  }
  absl::Status operator()(const Image& image) const { return ValidateBlob(image.content); }
  absl::Status operator()(const PointCloud& cloud) const { return ValidateBlob(cloud.content); }
  absl::Status operator()(const Withheld& withheld) const { return ValidateReason("withheld.reason", withheld.reason); }
  absl::Status operator()(const DoorReport& report) const {
    if (absl::Status status = ValidateTime(report.door_time); !status.ok()) return status;
    if (report.level_time) {
      if (absl::Status status = ValidateTime(*report.level_time); !status.ok()) return status;
      if (*report.level_time > report.time) {
        return InvalidArgument("door_report.level_time is {} s after its time",
                               ToSeconds(*report.level_time - report.time));
      }
    }
    if (report.door_time > report.time) {
      return InvalidArgument("door_report.door_time is {} s after its time", ToSeconds(report.door_time - report.time));
    }
    if (!IsFinite(report.T_odom_door)) return InvalidArgument("door_report.pose_odom_door is not finite");
    if (report.T_odom_gap && !IsFinite(*report.T_odom_gap)) {
      return InvalidArgument("door_report.pose_odom_gap is not finite");
    }
    if (!(report.width >= 0.0 && report.width < 1000.0)) {
      return InvalidArgument("door_report.width_m is {}: expected 0 to 1000", report.width);
    }
    return ValidateReason("door_report.reason", report.reason);
  }
};

}  // namespace

RecordKind KindOf(const Record& record) { return static_cast<RecordKind>(record.payload.index() + 1); }

TimeNs TimeOf(const RecordPayload& payload) {
  return std::visit(
      [](const auto& kind) -> TimeNs {
        if constexpr (requires { kind.time; }) {
          return kind.time;
        } else {
          return 0;
        }
      },
      payload);
}

const BlobRef* FindBlob(const RecordPayload& payload) {
  if (const auto* image = std::get_if<Image>(&payload)) return &image->content;
  if (const auto* cloud = std::get_if<PointCloud>(&payload)) return &cloud->content;
  return nullptr;
}

absl::Status Validate(const RecordPayload& payload) {
  if (absl::Status status = ValidateTime(TimeOf(payload)); !status.ok()) return status;
  return std::visit(PayloadCheck{}, payload);
}

absl::Status Validate(const Record& record) {
  if (record.sequence < 1) return InvalidArgument("sequence is {}: sequences start at 1", record.sequence);
  return Validate(record.payload);
}

}  // namespace enfilade::sensor
