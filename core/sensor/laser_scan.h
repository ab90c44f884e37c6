// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "absl/status/status.h"
#include "core/base/time.h"
#include "core/geometry/pose2.h"

namespace enfilade::sensor {

// One planar scan. Beam i points along angle_min + i * angle_increment, counter-clockwise, in the laser's frame.
//
// A range in [range_min, range_max) is a hit at that distance. A range of range_max or more, +infinity included, means
// "no return": space is free up to range_max. NaN, negative ranges (REP 117's -inf) and ranges below range_min mean
// "unknown". Ranges are single precision, as scanners deliver them; everything computed from them is double.
struct LaserScan {
  TimeNs time = 0;               // of the first beam
  double angle_min = 0.0;        // rad
  double angle_increment = 0.0;  // rad; negative for a scanner that turns clockwise
  double time_increment = 0.0;   // s between beams; 0 if unknown
  float range_min = 0.0F;        // m
  float range_max = 0.0F;        // m
  Pose2 T_robot_laser;           // where the scanner is mounted
  std::vector<float> ranges;     // m

  double angle(std::size_t beam) const { return angle_min + static_cast<double>(beam) * angle_increment; }

  friend bool operator==(const LaserScan&, const LaserScan&) = default;
};

enum class BeamKind { kHit, kNoReturn, kUnknown };

inline BeamKind ClassifyBeam(const LaserScan& scan, float range) {
  if (range >= scan.range_max) return BeamKind::kNoReturn;
  if (range >= scan.range_min && range >= 0.0F) return BeamKind::kHit;
  return BeamKind::kUnknown;  // NaN compares false with everything
}

struct BeamCounts {
  std::size_t hits = 0;
  std::size_t no_returns = 0;
  std::size_t unknown = 0;
};

BeamCounts CountBeams(const LaserScan& scan);

// The end points of the hits nearer than `max_range` (m), in the robot's frame.
std::vector<Eigen::Vector2d> HitPoints(const LaserScan& scan, double max_range);

// At most this many beams in one scan.
constexpr std::size_t kMaxBeams = 100'000;
// A scanner is mounted at most this far from the robot's origin, m.
constexpr double kMaxMountDistance = 20.0;

// INVALID_ARGUMENT naming the field: no beams, more than kMaxBeams, non-finite or zero angles, range_max <= range_min,
// negative or non-finite limits, a non-finite mount or one beyond kMaxMountDistance. The ranges themselves may have any
// value (see above).
absl::Status Validate(const LaserScan& scan);

}  // namespace enfilade::sensor
