// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/geometry/pose2.h"
#include "core/localization/localization_options.h"
#include "core/localization/searchable_map.h"
#include "core/sensor/laser_scan.h"

namespace enfilade::localization {

// A scan in the forms that it is searched, refined and compared in. Points in the robot's frame, m.
struct QueryPoints {
  Eigen::Vector2d laser = Eigen::Vector2d::Zero();
  std::vector<Eigen::Vector2d> hits;      // thinned
  std::vector<Eigen::Vector2d> searched;  // some of them
  std::vector<Eigen::Vector2d> beams;     // the ends of evenly chosen beams
};

QueryPoints PointsOf(const sensor::LaserScan& scan, const LocalizationOptions& options);

// What a scan at a pose says about the map being the right one. Shares are of the beams compared.
struct ScanEvidence {
  double log_likelihood = 0.0;  // mean over the beams, 0 (all on walls) or less
  // The same if what lies on unknown ground is as expected there: how far the known part of the map contradicts.
  double known_log_likelihood = 0.0;
  double matched = 0.0;  // ends on a wall
  double free = 0.0;     // ends in free space
  double through = 0.0;  // passes through a wall
  double unknown = 0.0;  // ends where the map is unknown

  double known() const { return matched + free + through; }
  double contradicted() const { return free + through; }
};

ScanEvidence Compare(const SearchableMap& map, const QueryPoints& scan, const Pose2& T_map_robot,
                     const LocalizationOptions& options);

}  // namespace enfilade::localization
