// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "absl/status/statusor.h"
#include "core/doors/derivative_detector.h"
#include "core/doors/door_event.h"
#include "core/doors/door_options.h"
#include "core/doors/gap_detector.h"
#include "core/sensor/laser_scan.h"

namespace enfilade::doors {

// Finds doors and the robot's passages through them in a stream of planar scans with odometry. Deterministic: the same
// scans give the same events, also across Serialize and Restore. Works with any planar scanner; criteria that a scanner
// cannot judge (no view behind the robot) are dropped, and the verdict says so.
class DoorDetector {
 public:
  explicit DoorDetector(const DoorOptions& options);

  // The events that this scan decides, in order. A scan that is invalid (core/sensor), older than the one before, or
  // whose pose is not finite is ignored.
  std::vector<DoorEvent> Add(const sensor::LaserScan& scan, const Pose2& T_odom_robot);
  // Ends the stream: latched doors become candidates.
  std::vector<DoorEvent> Finish();

  std::string Serialize() const;
  // DATA_LOSS on bytes that Serialize did not write with the same options.
  static absl::StatusOr<DoorDetector> Restore(const DoorOptions& options, std::string_view bytes);

 private:
  std::variant<GapDetector, DerivativeDetector> detector_;
  TimeNs last_time_ = -1;
};

}  // namespace enfilade::doors
