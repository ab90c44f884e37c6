// SPDX-License-Identifier: Apache-2.0
#include "core/slam/slam_options.h"

#include <cmath>
#include <string_view>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/slam/slam_option_names.h"

namespace enfilade::slam {
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

struct Limits {
  const char* name;
  double low;
  double high;
};

constexpr Limits kLimits[] = {
    {"keyframe.distance", 0.01, 10.0},
    {"keyframe.angle", 0.01, M_PI},
    {"submap.max_keyframes", 2, 10'000},
    {"submap.max_extent", 1.0, 1'000.0},
    {"submap.carried_keyframes", 1, 1'000},
    {"motion.translation_per_metre", 0.0, 10.0},
    {"motion.translation_per_radian", 0.0, 10.0},
    {"motion.yaw_per_metre", 0.0, 10.0},
    {"motion.yaw_per_radian", 0.0, 10.0},
    {"motion.translation_floor", 1e-4, 10.0},
    {"motion.yaw_floor", 1e-4, M_PI},
    {"motion.free_translation", 1e-4, 10.0},
    {"motion.free_yaw", 1e-4, M_PI},
    {"motion.max_step", 0.1, 1e6},
    {"local.sigma", 1e-3, 1.0},
    {"local.kernel_width", 0.1, 100.0},
    {"local.matched_distance", 1e-3, 1.0},
    {"local.effective_beams", 1.0, 1e5},
    {"local.max_iterations", 1, 1'000},
    {"local.point_spacing", 0.0, 1.0},
    {"local.window_sigmas", 0.1, 10.0},
    {"local.max_half_width", 0.05, 10.0},
    {"local.search_sigma", 1e-2, 1.0},
    {"local.min_matched_share", 0.0, 1.0},
    {"local.min_agreement", 0.0, 1.0},
    {"local.sure_agreement", 0.0, 1.0},
    {"quality.lost_after", 1, 1'000},
    {"quality.new_submap_after", 1, 1'000},
    {"quality.lost_length", 0.0, 1e6},
    {"pyramid.levels", 1, 6},
    {"pyramid.sigma_in_cells", 0.1, 10.0},
    {"pyramid.inlier_cells", 0.1, 10.0},
    {"pyramid.min_inliers_coarsest", 0.0, 1.0},
    {"pyramid.min_inliers", 0.0, 1.0},
    {"pyramid.search_cell", 1e-2, 2.0},
    {"pyramid.search_sigma", 1e-2, 2.0},
    {"loop.min_submap_gap", 1, 1'000},
    {"loop.attempt_spacing", 1, 100'000},
    {"loop.accepted_spacing", 1, 100'000},
    {"loop.attempt_interval", 1, 100'000},
    {"loop.closure_spacing", 1, 100'000},
    {"loop.max_attempts", 1, 100},
    {"loop.max_distance", 0.0, 1e4},
    {"loop.search_base", 0.05, 100.0},
    {"loop.drift_per_metre", 0.0, 1.0},
    {"loop.max_search", 0.05, 100.0},
    {"loop.search_angle_base", 0.01, M_PI},
    {"loop.yaw_drift_per_metre", 0.0, 1.0},
    {"loop.min_points", 3, 100'000},
    {"loop.search_points", 10, 100'000},
    {"loop.min_search_score", 0.01, 1.0},
    {"loop.min_agreement", 0.0, 1.0},
    {"loop.min_entry_agreement", 0.0, 1.0},
    {"loop.max_sigma", 1e-3, 100.0},
    {"loop.ambiguity_distance", 0.1, 100.0},
    {"loop.ambiguity_angle", 0.01, M_PI},
    {"loop.max_ambiguity", 0.0, 1.0},
    {"loop.sigma_floor", 1e-4, 10.0},
    {"loop.yaw_floor", 1e-4, 1.0},
    {"loop.min_agreeing", 2, 10'000},
    {"loop.min_agreeing_length", 0.0, 1e4},
    {"loop.last_pass_length", 0.0, 1e6},
    {"loop.last_pass_range", 0.5, 1e3},
    {"loop.last_pass_widening", 0.0, 100.0},
    {"loop.cached_submaps", 1, 1'000},
    {"graph.kernel_width", 0.01, 1'000.0},
    {"graph.max_chi2", 0.1, 1e6},
    {"graph.max_iterations", 1, 10'000},
    {"graph.match_sigma_floor", 1e-4, 10.0},
    {"graph.match_yaw_floor", 1e-4, 1.0},
    {"graph.urgent_chi2", 0.0, 1e6},
    {"graph.growth", 0.0, 10.0},
    {"graph.urgent_growth", 0.0, 10.0},
};

}  // namespace

absl::Status SlamOptions::Validate() const {
  ENFILADE_RETURN_IF_ERROR(Within("resolution", resolution, 0.005, 1.0));
  ENFILADE_RETURN_IF_ERROR(Within("max_range", max_range, 0.5, 200.0));
  ENFILADE_RETURN_IF_ERROR(ValidateOccupancy(occupancy));
  absl::Status status;
  VisitSlamOptions(*this, [&](const char* name, const auto& value) {
    for (const Limits& limits : kLimits) {
      if (status.ok() && std::string_view(limits.name) == name) {
        status = Within(name, static_cast<double>(value), limits.low, limits.high);
      }
    }
  });
  return status;
}

}  // namespace enfilade::slam
