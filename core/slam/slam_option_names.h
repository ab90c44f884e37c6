// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/slam/slam_options.h"

namespace enfilade::slam {

// Calls visit("group.name", value) for every option, in the order of slam_options.h. `Options` is SlamOptions, const or
// not; values are bool, int or double. The only list of the names.
template <typename Options, typename Visit>
void VisitSlamOptions(Options& o, Visit visit) {
  visit("resolution", o.resolution);
  visit("match_scans", o.match_scans);
  visit("close_loops", o.close_loops);
  visit("max_range", o.max_range);
  visit("occupancy.log_odds", o.occupancy.log_odds);
  visit("occupancy.hit_probability", o.occupancy.hit_probability);
  visit("occupancy.miss_probability", o.occupancy.miss_probability);
  visit("occupancy.min_probability", o.occupancy.min_probability);
  visit("occupancy.max_probability", o.occupancy.max_probability);
  visit("occupancy.no_return_range", o.occupancy.no_return_range);
  visit("keyframe.distance", o.keyframe.distance);
  visit("keyframe.angle", o.keyframe.angle);
  visit("submap.max_keyframes", o.submap.max_keyframes);
  visit("submap.max_extent", o.submap.max_extent);
  visit("submap.carried_keyframes", o.submap.carried_keyframes);
  visit("motion.translation_per_metre", o.motion.translation_per_metre);
  visit("motion.translation_per_radian", o.motion.translation_per_radian);
  visit("motion.yaw_per_metre", o.motion.yaw_per_metre);
  visit("motion.yaw_per_radian", o.motion.yaw_per_radian);
  visit("motion.translation_floor", o.motion.translation_floor);
  visit("motion.yaw_floor", o.motion.yaw_floor);
  visit("motion.free_translation", o.motion.free_translation);
  visit("motion.free_yaw", o.motion.free_yaw);
  visit("motion.max_step", o.motion.max_step);
  visit("local.sigma", o.local.field.sigma);
  visit("local.kernel_width", o.local.field.kernel_width);
  visit("local.matched_distance", o.local.field.matched_distance);
  visit("local.effective_beams", o.local.field.effective_beams);
  visit("local.max_iterations", o.local.field.max_iterations);
  visit("local.point_spacing", o.local.point_spacing);
  visit("local.window_sigmas", o.local.window_sigmas);
  visit("local.max_half_width", o.local.max_half_width);
  visit("local.search_sigma", o.local.search_sigma);
  visit("local.min_matched_share", o.local.min_matched_share);
  visit("local.min_agreement", o.local.min_agreement);
  visit("local.sure_agreement", o.local.sure_agreement);
  visit("quality.lost_after", o.quality.lost_after);
  visit("quality.new_submap_after", o.quality.new_submap_after);
  visit("quality.lost_length", o.quality.lost_length);
  visit("pyramid.levels", o.pyramid.levels);
  visit("pyramid.sigma_in_cells", o.pyramid.sigma_in_cells);
  visit("pyramid.inlier_cells", o.pyramid.inlier_cells);
  visit("pyramid.min_inliers_coarsest", o.pyramid.min_inliers_coarsest);
  visit("pyramid.min_inliers", o.pyramid.min_inliers);
  visit("pyramid.search_cell", o.pyramid.search_cell);
  visit("pyramid.search_sigma", o.pyramid.search_sigma);
  visit("loop.min_submap_gap", o.loop.min_submap_gap);
  visit("loop.attempt_spacing", o.loop.attempt_spacing);
  visit("loop.accepted_spacing", o.loop.accepted_spacing);
  visit("loop.attempt_interval", o.loop.attempt_interval);
  visit("loop.closure_spacing", o.loop.closure_spacing);
  visit("loop.max_attempts", o.loop.max_attempts);
  visit("loop.max_distance", o.loop.max_distance);
  visit("loop.search_base", o.loop.search_base);
  visit("loop.drift_per_metre", o.loop.drift_per_metre);
  visit("loop.max_search", o.loop.max_search);
  visit("loop.search_angle_base", o.loop.search_angle_base);
  visit("loop.yaw_drift_per_metre", o.loop.yaw_drift_per_metre);
  visit("loop.min_points", o.loop.min_points);
  visit("loop.search_points", o.loop.search_points);
  visit("loop.min_search_score", o.loop.min_search_score);
  visit("loop.min_agreement", o.loop.min_agreement);
  visit("loop.min_entry_agreement", o.loop.min_entry_agreement);
  visit("loop.max_sigma", o.loop.max_sigma);
  visit("loop.ambiguity_distance", o.loop.ambiguity_distance);
  visit("loop.ambiguity_angle", o.loop.ambiguity_angle);
  visit("loop.max_ambiguity", o.loop.max_ambiguity);
  visit("loop.sigma_floor", o.loop.sigma_floor);
  visit("loop.yaw_floor", o.loop.yaw_floor);
  visit("loop.min_agreeing", o.loop.min_agreeing);
  visit("loop.min_agreeing_length", o.loop.min_agreeing_length);
  visit("loop.last_pass_length", o.loop.last_pass_length);
  visit("loop.last_pass_range", o.loop.last_pass_range);
  visit("loop.last_pass_widening", o.loop.last_pass_widening);
  visit("loop.cached_submaps", o.loop.cached_submaps);
  visit("graph.kernel_width", o.graph.kernel_width);
  visit("graph.max_chi2", o.graph.max_chi2);
  visit("graph.max_iterations", o.graph.max_iterations);
  visit("graph.match_sigma_floor", o.graph.match_sigma_floor);
  visit("graph.match_yaw_floor", o.graph.match_yaw_floor);
  visit("graph.growth", o.graph.growth);
  visit("graph.urgent_growth", o.graph.urgent_growth);
  visit("graph.urgent_chi2", o.graph.urgent_chi2);
}

}  // namespace enfilade::slam
