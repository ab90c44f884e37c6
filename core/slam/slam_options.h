// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/status.h"

namespace enfilade::slam {

// How a scan changes the cells that its beams cross.
struct OccupancyOptions {
  // true: log-odds (Moravec, Elfes 1985). false: the simplified form, +1 for a hit and -1 for a crossing beam.
  bool log_odds = true;
  double hit_probability = 0.70;   // of a cell in which a beam ends
  double miss_probability = 0.40;  // of a cell that a beam crosses
  // A cell's probability is clamped to these, so that objects that moved are unlearnt (Hornung et al. 2013).
  double min_probability = 0.1192;
  double max_probability = 0.971;
  // How far a beam without return clears cells, m. 0: not at all, since dark and specular surfaces absorb beams.
  double no_return_range = 0.0;
};

// When a scan becomes a keyframe.
struct KeyframeOptions {
  double distance = 0.3;  // m from the last keyframe
  double angle = 0.26;    // rad from the last keyframe (15 deg)
};

// When a new submap begins.
struct SubmapOptions {
  int max_keyframes = 40;      // without the carried ones
  double max_extent = 40.0;    // m from the submap's origin to a keyframe's position
  int carried_keyframes = 10;  // last ones of a submap, copied into the next
};

// How accurate the predicted motion between scans is (odometry model of Thrun, Burgard, Fox, "Probabilistic Robotics",
// 2005, section 5.4).
struct MotionOptions {
  // Standard deviations of odometry: floor + per metre * length + per radian * |turn|. Wheels slip most in turns.
  double translation_per_metre = 0.10;   // m per m
  double translation_per_radian = 0.05;  // m per rad
  double yaw_per_metre = 0.05;           // rad per m (3 deg)
  double yaw_per_radian = 0.10;          // rad per rad
  double translation_floor = 0.03;       // m
  double yaw_floor = 0.02;               // rad
  // Without odometry, constant velocity is assumed. Standard deviations per scan.
  double free_translation = 0.40;  // m
  double free_yaw = 0.40;          // rad
  // Odometry that jumps farther than this between two scans is ignored, m.
  double max_step = 20.0;
};

// How a scan is matched to a likelihood field (MatchToField).
struct FieldMatchOptions {
  double sigma = 0.05;             // m, of hits about their wall: range noise, discretisation, clutter
  double kernel_width = 2.0;       // of Cauchy's kernel, in sigmas
  double matched_distance = 0.12;  // m, from a hit to the nearest wall
  // Errors of neighbouring beams are correlated: a scan counts as at most this many independent beams.
  double effective_beams = 60.0;
  int max_iterations = 20;
};

// How each scan is matched to the active submap.
struct LocalMatchOptions {
  FieldMatchOptions field;
  double point_spacing = 0.05;  // m: points nearer than this to their neighbour in the scan are left out
  // Half-width of the search window, in standard deviations of the predicted motion, and its bound.
  double window_sigmas = 3.0;
  double max_half_width = 2.5;  // m
  double search_sigma = 0.10;   // m, of the likelihood in the search: broad, to attract poses from afar
  // A match is good if at least this share of all hits fits the map, and ...
  double min_matched_share = 0.30;
  // ... of the hits on known ground, at least this share.
  double min_agreement = 0.65;
  // Below this share of the hits on known ground, wider windows are searched.
  double sure_agreement = 0.85;
};

// When the robot counts as lost, and what happens then.
struct QualityOptions {
  int lost_after = 3;        // consecutive scans without a good match
  int new_submap_after = 5;  // consecutive scans that contradict the map: a new submap begins at the estimated pose
  // The length of the path into that submap, for the possible drift, m: loop closures are searched in wide windows.
  double lost_length = 100.0;
};

// The likelihood fields, from coarse to fine, in which finished submaps are searched and matched.
struct PyramidOptions {
  int levels = 4;               // cells halve from level to level, down to the map's: 0.4, 0.2, 0.1, 0.05 m
  double sigma_in_cells = 0.5;  // sigma of a level's matching, but at least local.sigma
  double inlier_cells = 1.0;    // inliers are at most this, or local.matched_distance, away from a wall
  // The required share of inliers at the coarsest and at the finest level; linear in between.
  double min_inliers_coarsest = 0.60;
  double min_inliers = 0.45;
  double search_cell = 0.10;   // m, of the search table
  double search_sigma = 0.15;  // m, of its likelihood
};

// When and where loop closures are tried, and when they are accepted.
struct LoopOptions {
  int min_submap_gap = 2;     // submaps back from the node's own, at least
  int attempt_spacing = 3;    // keyframes between two attempts at the same submap ...
  int accepted_spacing = 10;  // ... and after a closure with it
  int attempt_interval = 2;   // keyframes between two attempts at any submaps ...
  int closure_spacing = 6;    // ... and after a closure with any: the next ones would add nothing new
  int max_attempts = 1;       // per keyframe
  double max_distance = 4.0;  // m to the submap's nearest keyframe, in addition to the drift
  // The search's half-widths: a base plus the possible drift along the path through the graph (DriftLengths).
  double search_base = 0.5;            // m
  double drift_per_metre = 0.03;       // m per m
  double max_search = 8.0;             // m
  double search_angle_base = 0.15;     // rad
  double yaw_drift_per_metre = 0.005;  // rad per m
  int min_points = 30;                 // of a scan, for an attempt
  int search_points = 100;             // of a scan, in the search
  double min_search_score = 0.40;      // mean likelihood
  double min_agreement = 0.75;         // share on walls of the hits on known ground
  // The same until the robot is found in an existing map: until then nothing else rules out look-alikes.
  double min_entry_agreement = 0.85;
  double max_sigma = 0.25;  // m, of the position in its least certain direction
  // A match is ambiguous if a place at least this far from the best scores more than this share of its score.
  double ambiguity_distance = 1.0;  // m
  double ambiguity_angle = 0.5;     // rad
  double max_ambiguity = 0.95;
  // Standard deviations added to a closure's information, for the distortion of the submap.
  double sigma_floor = 0.05;  // m
  double yaw_floor = 0.01;    // rad
  // Closures that the graph rejects hold against it if so many agree with one another, from keyframes so far apart.
  int min_agreeing = 3;
  double min_agreeing_length = 1.0;  // m
  // When the session finishes, submaps that are tied to each other only by ways longer than this are compared, by what
  // the later one shows so far around a keyframe.
  double last_pass_length = 20.0;   // m
  double last_pass_range = 12.0;    // m
  double last_pass_widening = 2.0;  // of the possible drift
  int cached_submaps = 8;           // decompressed, about 5 MB each
};

// How the pose graph is solved.
struct GraphOptions {
  double kernel_width = 1.0;  // of Cauchy's kernel on loop closures, in standard deviations
  double max_chi2 = 16.3;     // closures above are rejected: 99.9 % quantile for three degrees of freedom
  int max_iterations = 50;
  // Standard deviations added to the result of matching a scan to the active submap.
  double match_sigma_floor = 0.02;  // m
  double match_yaw_floor = 0.005;   // rad
  // After a loop closure, the graph is solved once it has grown by the share `growth` since the last time, or by
  // `urgent_growth` if the closure's chi2 at the estimate is above `urgent_chi2`. Shares, not counts, keep the cost per
  // keyframe constant on long drives.
  double growth = 0.10;
  double urgent_growth = 0.02;
  double urgent_chi2 = 16.3;
};

// Every parameter of the mapper, with unit, default and source.
struct SlamOptions {
  // The side of a cell of the map, m.
  double resolution = 0.05;
  // false: poses follow the odometry, uncorrected; scans without odometry are not used.
  bool match_scans = true;
  bool close_loops = true;
  // Hits farther away than this are ignored, m.
  double max_range = 30.0;

  OccupancyOptions occupancy;
  KeyframeOptions keyframe;
  SubmapOptions submap;
  MotionOptions motion;
  LocalMatchOptions local;
  QualityOptions quality;
  PyramidOptions pyramid;
  LoopOptions loop;
  GraphOptions graph;

  // INVALID_ARGUMENT naming the option.
  absl::Status Validate() const;
};

}  // namespace enfilade::slam
