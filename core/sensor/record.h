// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "absl/status/status.h"
#include "core/base/environment.h"
#include "core/base/time.h"
#include "core/geometry/pose2.h"
#include "core/graph/link_point_kind.h"
#include "core/sensor/environment_choice.h"
#include "core/sensor/laser_scan.h"

namespace enfilade::sensor {

// The robot's pose from its wheel odometry, in the odometry frame: continuous, drifting.
struct Odometry {
  TimeNs time = 0;
  Pose2 T_odom_robot;

  friend bool operator==(const Odometry&, const Odometry&) = default;
};

// A reference to content-addressed bytes, which are sent and stored once per site, apart from the record.
struct BlobRef {
  std::string sha256;  // 32 raw bytes
  std::int64_t size = 0;

  friend bool operator==(const BlobRef&, const BlobRef&) = default;
};

// At most this many bytes in one image or point cloud.
constexpr std::int64_t kMaxBlobBytes = 64LL << 20;

enum class Camera : std::uint8_t { kFront = 1, kRear = 2 };
enum class ImageEncoding : std::uint8_t { kPng = 1, kJpeg = 2, kDepthPng16 = 3 };

struct Image {
  TimeNs time = 0;
  Camera camera = Camera::kFront;
  ImageEncoding encoding = ImageEncoding::kPng;
  BlobRef content;

  friend bool operator==(const Image&, const Image&) = default;
};

enum class CloudEncoding : std::uint8_t { kPcd = 1, kXyz32 = 2 };  // kXyz32: float32 x y z, metres, robot's frame

struct PointCloud {
  TimeNs time = 0;
  CloudEncoding encoding = CloudEncoding::kPcd;
  BlobRef content;

  friend bool operator==(const PointCloud&, const PointCloud&) = default;
};

// A door that a robot detected (core/doors): seen ahead but not driven through, or driven through. The evidence is the
// images and clouds that the session recorded between about `door_time` and `time`.
struct DoorReport {
  enum class Kind : std::uint8_t {
    kCandidate = 1,  // the door lies ahead of the robot at `door_time`
    kPassage = 2,    // the robot has left the session's map: the session's last door, and its end
  };

  TimeNs time = 0;  // when the report was made
  Kind kind = Kind::kCandidate;
  graph::LinkPointKind place = graph::LinkPointKind::kDoor;
  TimeNs door_time = 0;  // when the robot was at T_odom_door
  Pose2 T_odom_door;     // the robot's pose at the door, facing through it
  double width = 0.0;    // m; 0: unknown
  // kPassage only: the environment behind the door, for a new map.
  std::optional<Environment> entered_environment;
  std::optional<std::int32_t> entered_level;  // unset: unchanged
  bool by_hand = false;                       // reported by a person, not the detector
  std::string reason;                         // human-readable
  // kPassage only: when the robot came to entered_level, if that was before the door, in the cabin of a lift.
  std::optional<TimeNs> level_time = {};
  // kCandidate only: the middle of the gap that was taken for a door, facing through it. Unset: somewhere ahead.
  std::optional<Pose2> T_odom_gap = {};

  friend bool operator==(const DoorReport&, const DoorReport&) = default;
};

// Takes the place of a record that the server refused and the robot withholds, so that the log's sequence has no holes
// and the loss is recorded.
struct Withheld {
  std::string reason;

  friend bool operator==(const Withheld&, const Withheld&) = default;
};

using RecordPayload = std::variant<LaserScan, Odometry, Image, PointCloud, Withheld, DoorReport>;

// One entry of a session's log. Sequences start at 1 and have no holes.
struct Record {
  std::int64_t sequence = 0;
  RecordPayload payload;

  friend bool operator==(const Record&, const Record&) = default;
};

// Stored beside the payload, to select by. The numbers are in the database and in spools: never reuse one.
enum class RecordKind : std::int16_t {
  kLaserScan = 1,
  kOdometry = 2,
  kImage = 3,
  kPointCloud = 4,
  kWithheld = 5,
  kDoorReport = 6
};

RecordKind KindOf(const Record& record);
// 0 for Withheld.
TimeNs TimeOf(const RecordPayload& payload);
inline TimeNs TimeOf(const Record& record) { return TimeOf(record.payload); }
// The blob that an image or point cloud refers to, otherwise nullptr.
const BlobRef* FindBlob(const RecordPayload& payload);
inline const BlobRef* FindBlob(const Record& record) { return FindBlob(record.payload); }

// INVALID_ARGUMENT naming the field: a time before 1970 or after 2200, a non-finite pose, a blob reference of the wrong
// size, and everything that Validate(LaserScan) refuses.
absl::Status Validate(const RecordPayload& payload);
// Also refuses a sequence below 1.
absl::Status Validate(const Record& record);

}  // namespace enfilade::sensor
