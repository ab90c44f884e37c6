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

// Finds doors and the robot's passages through them in a stream of planar scans with odometry. Pure state: the same
// scans give the same events, also across Serialize and Restore. Any planar scanner will do; what one cannot tell (no
// view behind it, no beams at all) the verdicts say.
class DoorDetector {
 public:
  explicit DoorDetector(const DoorOptions& options);

  // The events that this scan settles, in order. A scan that is not valid (core/sensor), is older than the one before,
  // or has a pose that is not finite passes by without an effect.
  std::vector<DoorEvent> Add(const sensor::LaserScan& scan, const Pose2& T_odom_robot);
  // Nothing more will come: latched doors become candidates.
  std::vector<DoorEvent> Finish();

  std::string Serialize() const;
  // DATA_LOSS on bytes that Serialize did not write with the same options.
  static absl::StatusOr<DoorDetector> Restore(const DoorOptions& options, std::string_view bytes);

 private:
  std::variant<GapDetector, DerivativeDetector> detector_;
  TimeNs last_time_ = -1;
};

}  // namespace enfilade::doors
