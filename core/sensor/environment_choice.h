// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "absl/status/statusor.h"
#include "core/base/environment.h"
#include "core/sensor/laser_scan.h"

namespace enfilade::sensor {

// The original's criterion 0: outdoors where at least two of the four sides of the filtered scan's box are far away.
struct RangeCriterion {
  double side_limit = 13.0;  // m, range_thr
  int half_width = 60;       // beams to either side, low_pass_filter_size
  int sides_needed = 2;      // of 4

  // params.yaml of the original: 13.0 m; the defaults of its C++: 10.0 m.
  static RangeCriterion OriginalYaml() { return {.side_limit = 13.0, .half_width = 60, .sides_needed = 2}; }
  static RangeCriterion OriginalCode() { return {.side_limit = 10.0, .half_width = 60, .sides_needed = 2}; }
};

absl::Status Validate(const RangeCriterion& criterion);

struct RangeChoice {
  // nullopt: the scan has no hit to judge by.
  std::optional<Environment> surroundings;
  double front = 0.0;  // m, distance of each side of the box from the robot, as absolute values
  double back = 0.0;
  double left = 0.0;
  double right = 0.0;
  int far_sides = 0;
};

// In the robot's frame. INVALID_ARGUMENT: criterion or scan (Validate).
absl::StatusOr<RangeChoice> ChooseByRange(const LaserScan& scan, const RangeCriterion& criterion = {});

}  // namespace enfilade::sensor
