#include "core/slam/slam_options.h"

#include <cmath>

#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade {
namespace {

absl::Status Within(const char* name, double value, double low, double high) {
  if (value >= low && value <= high) return absl::OkStatus();
  return InvalidArgument("slam.{} is {}: expected {} to {}", name, value, low, high);
}

absl::Status ValidateOccupancy(const OccupancyOptions& o) {
  ENFILADE_RETURN_IF_ERROR(Within("occupancy.hit_probability", o.hit_probability, 0.501, 0.999));
  ENFILADE_RETURN_IF_ERROR(Within("occupancy.miss_probability", o.miss_probability, 0.001, 0.499));
  ENFILADE_RETURN_IF_ERROR(Within("occupancy.min_probability", o.min_probability, 0.001, 0.499));
  ENFILADE_RETURN_IF_ERROR(Within("occupancy.max_probability", o.max_probability, 0.501, 0.999));
  if (o.min_probability >= o.miss_probability || o.hit_probability >= o.max_probability) {
    return InvalidArgument(
        "slam.occupancy: expected min_probability < miss_probability and hit_probability < max_probability");
  }
  return Within("occupancy.no_return_range", o.no_return_range, 0.0, 200.0);
}

}  // namespace

absl::Status SlamOptions::Validate() const {
  ENFILADE_RETURN_IF_ERROR(Within("resolution", resolution, 0.005, 1.0));
  ENFILADE_RETURN_IF_ERROR(Within("max_range", max_range, 0.5, 200.0));
  ENFILADE_RETURN_IF_ERROR(ValidateOccupancy(occupancy));
  ENFILADE_RETURN_IF_ERROR(Within("keyframe.distance", keyframe.distance, 0.01, 10.0));
  ENFILADE_RETURN_IF_ERROR(Within("keyframe.angle", keyframe.angle, 0.01, M_PI));
  ENFILADE_RETURN_IF_ERROR(Within("submap.max_keyframes", submap.max_keyframes, 2, 10'000));
  ENFILADE_RETURN_IF_ERROR(Within("submap.max_extent", submap.max_extent, 1.0, 1'000.0));
  return Within("submap.carried_keyframes", submap.carried_keyframes, 1, 1'000);
}

}  // namespace enfilade
