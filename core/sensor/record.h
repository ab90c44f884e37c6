#pragma once

#include <cstdint>
#include <string>
#include <variant>

#include "absl/status/status.h"
#include "core/base/time.h"
#include "core/geometry/pose2.h"
#include "core/sensor/laser_scan.h"

namespace enfilade {

// The robot's pose by its wheels, in the odometry frame: drifting, continuous.
struct Odometry {
  TimeNs time = 0;
  Pose2 T_odom_robot;

  friend bool operator==(const Odometry&, const Odometry&) = default;
};

// Content-addressed bytes: sent and stored once per site, apart from the record that refers to them.
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

// Stands in the log where the robot keeps a record back that the server refused, so that the sequence stays without
// holes and the loss is on record.
struct Withheld {
  std::string reason;

  friend bool operator==(const Withheld&, const Withheld&) = default;
};

// One entry of a session's log. Sequences start at 1 and have no holes.
struct Record {
  std::int64_t sequence = 0;
  std::variant<LaserScan, Odometry, Image, PointCloud, Withheld> payload;

  friend bool operator==(const Record&, const Record&) = default;
};

// What is stored beside the payload to select by; the numbers are in the database and in spools: never reuse one.
enum class RecordKind : std::int16_t { kLaserScan = 1, kOdometry = 2, kImage = 3, kPointCloud = 4, kWithheld = 5 };

RecordKind KindOf(const Record& record);
// The payload's time; 0 for Withheld.
TimeNs TimeOf(const Record& record);
// The blob that an image or point cloud refers to, otherwise nullptr.
const BlobRef* FindBlob(const Record& record);

// INVALID_ARGUMENT naming the field: a sequence below 1, a non-finite pose, a blob reference of the wrong size, and all
// that Validate(LaserScan) refuses.
absl::Status Validate(const Record& record);

}  // namespace enfilade
