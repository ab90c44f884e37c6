// SPDX-License-Identifier: Apache-2.0
#include "core/sensor/session_entry.h"

#include "core/base/binary.h"
#include "core/base/error.h"
#include "core/geometry/pose_codec.h"

namespace enfilade::sensor {
namespace {

constexpr std::uint8_t kEntryVersion = 1;

}  // namespace

std::string Encode(const SessionEntry& entry) {
  std::string bytes;
  if (!entry.previous && !entry.T_map_robot && !entry.T_odom_robot) return bytes;
  BinaryWriter writer(bytes);
  writer.Put(kEntryVersion);
  writer.PutString(entry.previous ? entry.previous->value() : "");
  writer.Put(entry.T_map_robot.has_value());
  if (entry.T_map_robot) {
    PutPose(writer, entry.T_map_robot->pose);
    PutMatrix(writer, entry.T_map_robot->covariance);
  }
  writer.Put(entry.T_odom_robot.has_value());
  if (entry.T_odom_robot) PutPose(writer, *entry.T_odom_robot);
  return bytes;
}

absl::StatusOr<SessionEntry> DecodeSessionEntry(std::string_view bytes) {
  SessionEntry entry;
  if (bytes.empty()) return entry;
  BinaryReader reader(bytes);
  if (const auto version = reader.Get<std::uint8_t>(); version != kEntryVersion) {
    return DataLoss("the session's entry: version {} is unknown to this program", version);
  }
  if (const std::string_view previous = reader.GetString(); !previous.empty()) {
    entry.previous = SessionId(std::string(previous));
  }
  if (reader.Get<bool>()) {
    PoseWithCovariance initial;
    initial.pose = GetPose(reader);
    initial.covariance = GetMatrix(reader);
    entry.T_map_robot = initial;
  }
  if (reader.Get<bool>()) entry.T_odom_robot = GetPose(reader);
  if (!reader.at_end()) return DataLoss("the session's entry is truncated or has trailing bytes");
  return entry;
}

}  // namespace enfilade::sensor
