#pragma once

#include "absl/status/status.h"

namespace enfilade {

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

  // INVALID_ARGUMENT naming the option.
  absl::Status Validate() const;
};

}  // namespace enfilade
