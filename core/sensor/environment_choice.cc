// SPDX-License-Identifier: Apache-2.0
#include "core/sensor/environment_choice.h"

#include <cmath>

#include "core/base/environment.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/sensor/scan_box.h"

namespace enfilade::sensor {

absl::Status Validate(const RangeCriterion& criterion) {
  if (!(criterion.side_limit > 0.0) || criterion.half_width < 0 || criterion.sides_needed < 1 ||
      criterion.sides_needed > 4) {
    return InvalidArgument(
        "range criterion: {} m, {} beams, {} sides: expected a positive distance, a half width of at "
        "least 0 and 1 to 4 sides",
        criterion.side_limit, criterion.half_width, criterion.sides_needed);
  }
  return absl::OkStatus();
}

absl::StatusOr<RangeChoice> ChooseByRange(const LaserScan& scan, const RangeCriterion& criterion) {
  ENFILADE_RETURN_IF_ERROR(Validate(criterion));
  ENFILADE_RETURN_IF_ERROR(Validate(scan));
  RangeChoice choice;
  const Eigen::AlignedBox2d box = FilteredBox(scan, criterion.half_width);
  if (box.isEmpty()) return choice;
  choice.front = std::abs(box.max().x());
  choice.back = std::abs(box.min().x());
  choice.left = std::abs(box.max().y());
  choice.right = std::abs(box.min().y());
  for (const double side : {choice.front, choice.back, choice.left, choice.right}) {
    if (side > criterion.side_limit) ++choice.far_sides;
  }
  choice.environment = choice.far_sides >= criterion.sides_needed ? Environment::kOutdoor : Environment::kIndoor;
  return choice;
}

}  // namespace enfilade::sensor
