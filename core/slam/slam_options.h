#pragma once

#include "absl/status/status.h"

namespace enfilade {

// Every parameter of the mapper, with unit, default and source.
struct SlamOptions {
  // The side of a cell of the map, m.
  double resolution = 0.05;
  // false: poses are the odometry's, corrected by nothing; a scan without odometry is not used.
  bool match_scans = true;
  bool close_loops = true;
  // Hits farther than this take no part, m.
  double max_range = 30.0;

  // INVALID_ARGUMENT naming the option.
  absl::Status Validate() const;
};

}  // namespace enfilade
