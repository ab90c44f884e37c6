// SPDX-License-Identifier: Apache-2.0
// Records and session entries as in spools and the record log. The first byte selects the kind.
#include <limits>

#include "core/sensor/record_codec.h"
#include "core/sensor/session_entry.h"
#include "tests/fuzz/decoder.h"

namespace enfilade::fuzz {
namespace {

constexpr TimeNs kTime = 1'700'000'000'000'000'000;
constexpr char kEntry = 0;  // not a record but how its session began

std::vector<sensor::RecordPayload> Payloads() {
  sensor::LaserScan scan;
  scan.time = kTime;
  scan.angle_increment = 0.1;
  scan.range_max = 10.0F;
  scan.ranges = {1.0F, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()};
  const sensor::BlobRef blob{std::string(32, 'h'), 1000};
  sensor::DoorReport door;
  door.entered_environment = Environment::kIndoor;
  door.entered_level = 1;
  door.level_time = kTime;
  door.T_odom_gap = Pose2{1.0, 2.0, 3.0};
  door.reason = "a door";
  return {scan,
          sensor::Odometry{kTime, {1.0, 2.0, 3.0}},
          sensor::Image{kTime, sensor::Camera::kRear, sensor::ImageEncoding::kPng, blob},
          sensor::PointCloud{kTime, sensor::CloudEncoding::kPcd, blob},
          sensor::Withheld{"refused"},
          door};
}

}  // namespace

std::vector<std::string> Seeds() {
  std::vector<std::string> seeds;
  for (const sensor::RecordPayload& payload : Payloads()) {
    const sensor::Record record{1, payload};
    seeds.push_back(static_cast<char>(sensor::KindOf(record)) + sensor::EncodePayload(record));
  }
  sensor::SessionEntry entry;
  entry.T_map_robot = PoseWithCovariance{{1.0, 2.0, 0.5}, Eigen::Matrix3d::Identity()};
  entry.T_odom_robot = Pose2{1.0, 0.0, 0.0};
  seeds.push_back(kEntry + sensor::Encode(entry));
  return seeds;
}

bool Decode(std::string_view bytes) {
  if (bytes.empty()) return false;
  const char kind = bytes.front();
  bytes.remove_prefix(1);
  if (kind == kEntry) {
    const auto entry = sensor::DecodeSessionEntry(bytes);
    if (entry.ok()) Expect(sensor::DecodeSessionEntry(sensor::Encode(*entry)).ok(), "an entry is read back");
    return entry.ok();
  }
  const auto record = sensor::DecodePayload(1, static_cast<sensor::RecordKind>(kind), bytes);
  if (!record.ok()) return false;
  (void)sensor::Validate(*record);
  const std::string again = sensor::EncodePayload(*record);
  const auto same = sensor::DecodePayload(1, sensor::KindOf(*record), again);
  Expect(same.ok() && sensor::EncodePayload(*same) == again, "a record is read back bit for bit");
  return true;
}

}  // namespace enfilade::fuzz
