// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/status.h"

namespace enfilade::slam {

// How one scan changes the cells that its beams cross.
struct OccupancyOptions {
  // true: log-odds (Moravec, Elfes 1985). false: the simplified form, +1 for a hit and -1 for a crossing beam.
  bool log_odds = true;
  double hit_probability = 0.70;   // of a cell in which a beam ends
  double miss_probability = 0.40;  // of a cell that a beam crosses
  // A cell's probability stays within these, so that a moved object can be unlearnt (Hornung et al. 2013).
  double min_probability = 0.1192;
  double max_probability = 0.971;
  // How far a beam without return clears the space, m. 0: dark and specular surfaces swallow beams too.
  double no_return_range = 0.0;
};

// When a scan becomes a keyframe (values of seed 001's implementations).
struct KeyframeOptions {
  double distance = 0.3;  // m from the last keyframe
  double angle = 0.26;    // rad from the last keyframe (15 deg)
};

// When a new submap begins.
struct SubmapOptions {
  int max_keyframes = 40;      // own ones, the carried ones not counted
  double max_extent = 40.0;    // m from the submap's origin to a keyframe's position
  int carried_keyframes = 10;  // of the last submap, copied into the new one
};

// How far to trust what is known of the way from one scan to the next (the form of the odometry model of Thrun,
// Burgard, Fox, "Probabilistic Robotics", 2005, section 5.4).
struct MotionOptions {
  // Of odometry, standard deviations. Wheels slip most where robots turn.
  double translation_per_metre = 0.10;   // m per m
  double translation_per_radian = 0.05;  // m per rad
  double yaw_per_metre = 0.05;           // rad per m (3 deg)
  double yaw_per_radian = 0.10;          // rad per rad
  double translation_floor = 0.03;       // m: at least this
  double yaw_floor = 0.02;               // rad
  // Without odometry the robot is taken to go on as it went; standard deviations per scan.
  double free_translation = 0.40;  // m
  double free_yaw = 0.40;          // rad
  // Odometry that jumps farther than this between two scans is not believed, m.
  double max_step = 20.0;
};

// How a scan is fitted to a likelihood field.
struct FieldMatchOptions {
  double sigma = 0.05;             // m, of a hit about its wall: ranging, cells and clutter
  double kernel_width = 2.0;       // of Cauchy's kernel, in sigmas
  double matched_distance = 0.12;  // m
  // Neighbouring beams err together: a scan counts as no more than this many independent ones.
  double effective_beams = 60.0;
  int max_iterations = 20;
};

// How each scan is matched to the active submap.
struct LocalMatchOptions {
  FieldMatchOptions field;
  double point_spacing = 0.05;  // m: nearer neighbours along a scan are left out
  // The search's window, in the predicted motion's standard deviations, and its bounds.
  double window_sigmas = 3.0;
  double max_half_width = 2.5;  // m
  double search_sigma = 0.10;   // m, of the likelihood in the search: broad, to find the way from afar
  // A match is good where at least this share of the hits fits the map ...
  double min_matched_share = 0.30;
  // ... and of the hits that fall where the map is known, at least this share does.
  double min_agreement = 0.65;
  // Below this share the search looks farther for something better.
  double sure_agreement = 0.85;
};

// When the robot counts as lost, and what then.
struct QualityOptions {
  int lost_after = 3;        // scans without a good match, one after the other
  int new_submap_after = 5;  // such scans: a new submap begins where the robot is thought to be
  // What the way into that submap counts for as drift, m: closures are looked for far and wide again.
  double lost_length = 100.0;
};

// The likelihood fields in which finished submaps are searched and matched, from coarse to fine.
struct PyramidOptions {
  int levels = 4;               // each of twice the cell of the next, the last the map's own: 0.4, 0.2, 0.1, 0.05 m
  double sigma_in_cells = 0.5;  // of a level's robust matching, but never below the local matching's sigma
  double inlier_cells = 1.0;    // a point is an inlier nearer than this to a wall, or than the matched distance
  // The share of inliers to go on after the coarsest level, and after the finest; between, in proportion.
  double min_inliers_coarsest = 0.60;
  double min_inliers = 0.45;
  double search_cell = 0.10;   // m, of the table for searching
  double search_sigma = 0.15;  // m, of its likelihood
};

// When and where a keyframe is looked for in old submaps, and what is taken for a closed loop.
struct LoopOptions {
  int min_submap_gap = 2;     // submaps: the node's own is 0, the one before 1
  int attempt_spacing = 3;    // keyframes between two attempts at the same submap ...
  int accepted_spacing = 10;  // ... and after a closure
  int attempt_interval = 2;   // keyframes between attempts at whichever submap ...
  int closure_spacing = 6;    // ... and after a closure with whichever: the next ones would say the same
  int max_attempts = 1;       // per keyframe
  double max_distance = 4.0;  // m to the submap's nearest keyframe, beside the drift
  // The search's half-widths: a base, and what may have drifted since, by the way through the graph.
  double search_base = 0.5;            // m
  double drift_per_metre = 0.03;       // m per m
  double max_search = 8.0;             // m
  double search_angle_base = 0.15;     // rad
  double yaw_drift_per_metre = 0.005;  // rad per m
  int min_points = 30;
  int search_points = 100;
  double min_search_score = 0.40;  // mean likelihood
  double min_agreement = 0.75;     // of the hits in the known part of the submap, share on walls
  // The same for finding the robot in an old map for the first time: nothing else there contradicts a look-alike.
  double min_entry_agreement = 0.85;
  double max_sigma = 0.25;  // m, in the direction that the walls leave the most open
  // Another place so far from the best that scores more than this share of its score makes the match ambiguous.
  double ambiguity_distance = 1.0;  // m
  double ambiguity_angle = 0.5;     // rad
  double max_ambiguity = 0.95;
  // What a closure's information leaves out: the submap's own distortion.
  double sigma_floor = 0.05;  // m
  double yaw_floor = 0.01;    // rad
  int cached_submaps = 8;     // decompressed, about 5 MB each
};

// How the pose graph is solved.
struct GraphOptions {
  double kernel_width = 1.0;  // of Cauchy's kernel on closures, in standard deviations (seed 001's implementations)
  double max_chi2 = 16.3;     // a closure beyond is invalid: 99.9 % of chi2 with three degrees of freedom
  int max_iterations = 50;
  // Errors of matching a scan to the active submap that the matching does not know of.
  double match_sigma_floor = 0.02;  // m
  double match_yaw_floor = 0.005;   // rad
  // The graph is solved when it has grown by `growth` since the last time; already at `urgent_growth` where a closure
  // has come that the estimate fits worse than `urgent_chi2`. Shares, not counts: the cost per keyframe stays the same
  // however long the drive.
  double growth = 0.10;
  double urgent_growth = 0.02;
  double urgent_chi2 = 16.3;
};

// Every parameter of the mapper, with unit, default and source.
struct SlamOptions {
  // The side of a cell of the map, m.
  double resolution = 0.05;
  // false: poses are the odometry's, corrected by nothing; a scan without odometry is not used.
  bool match_scans = true;
  bool close_loops = true;
  // Hits farther than this take no part, m.
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
