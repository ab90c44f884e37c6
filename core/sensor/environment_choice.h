// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "absl/status/statusor.h"
#include "core/base/environment.h"
#include "core/sensor/laser_scan.h"

namespace enfilade::sensor {

// map_manager's criterion 0: outdoors if at least `sides_needed` of the four sides of the filtered scan's box are more
// than `side_limit` away.
struct RangeCriterion {
  double side_limit = 13.0;  // m, range_thr
  int half_width = 60;       // beams to either side, low_pass_filter_size
  int sides_needed = 2;      // of 4

  // The parameters that map_manager publishes: 13.0 m in its params.yaml, 10.0 m as the default in its code.
  static RangeCriterion MapManagerYaml() { return {.side_limit = 13.0, .half_width = 60, .sides_needed = 2}; }
  static RangeCriterion MapManagerCode() { return {.side_limit = 10.0, .half_width = 60, .sides_needed = 2}; }
};

absl::Status Validate(const RangeCriterion& criterion);

struct RangeChoice {
  // nullopt: the scan has no hits.
  std::optional<Environment> environment;
  double front = 0.0;  // m, absolute distance of each side of the box from the robot
  double back = 0.0;
  double left = 0.0;
  double right = 0.0;
  int far_sides = 0;
};

// Uses the scan's box in the robot's frame. INVALID_ARGUMENT: criterion or scan (Validate).
absl::StatusOr<RangeChoice> ChooseByRange(const LaserScan& scan, const RangeCriterion& criterion = {});

}  // namespace enfilade::sensor
