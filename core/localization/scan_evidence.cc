// SPDX-License-Identifier: Apache-2.0
#include "core/localization/scan_evidence.h"

#include <algorithm>
#include <cmath>

#include "core/slam/matching/scan_points.h"

namespace enfilade::localization {
namespace {

constexpr double kStep = 0.05;        // m along a beam
constexpr double kAtLaser = 0.2;      // m of a beam that are not looked at
constexpr double kBeforeEnd = 0.25;   // m likewise: the wall that it ends at
constexpr double kBeyondWall = 0.15;  // m from a wall: a beam that gets there has not just grazed it

// Whether the beam goes through a wall of the map, and on. A beam that grazes a wall and ends near it does not.
bool PassesThrough(const SearchableMap& map, const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  const double length = (to - from).norm();
  const Eigen::Vector2d step = (to - from) * (kStep / std::max(length, kStep));
  const int last = static_cast<int>((length - kBeforeEnd) / kStep);
  bool in_wall = false;
  for (int i = static_cast<int>(kAtLaser / kStep); i <= last; ++i) {
    const Eigen::Vector2d at = from + i * step;
    if (map.At(at) == SearchableMap::Cell::kOccupied) {
      in_wall = true;
    } else if (in_wall && map.walls().At(at).squared_distance > kBeyondWall * kBeyondWall) {
      return true;
    }
  }
  return false;
}

}  // namespace

QueryPoints PointsOf(const sensor::LaserScan& scan, const LocalizationOptions& options) {
  QueryPoints points;
  points.laser = scan.T_robot_laser.translation();
  const std::vector<Eigen::Vector2d> all = sensor::HitPoints(scan, options.max_range);
  points.hits = slam::Thinned(all, options.point_spacing);
  points.searched = slam::Subsampled(points.hits, static_cast<std::size_t>(options.search_points));
  points.beams = slam::Subsampled(all, static_cast<std::size_t>(options.beams));
  return points;
}

ScanEvidence Compare(const SearchableMap& map, const QueryPoints& scan, const Pose2& T_map_robot,
                     const LocalizationOptions& options) {
  ScanEvidence evidence;
  if (scan.beams.empty()) return evidence;
  const double share = 1.0 / static_cast<double>(scan.beams.size());
  const double inverse = 0.5 / (options.hit_sigma * options.hit_sigma);
  const double matched2 = options.matched_distance * options.matched_distance;
  const Eigen::Vector2d laser = T_map_robot * scan.laser;
  for (const Eigen::Vector2d& beam : scan.beams) {
    const Eigen::Vector2d end = T_map_robot * beam;
    if (PassesThrough(map, laser, end)) {
      evidence.through += share;
      evidence.log_likelihood += share * std::log(options.through_likelihood);
      evidence.known_log_likelihood += share * std::log(options.through_likelihood);
      continue;
    }
    const double d2 = map.walls().At(end).squared_distance;
    const bool is_free = map.At(end) == SearchableMap::Cell::kFree;
    const double other = is_free ? options.free_likelihood : options.unknown_likelihood;
    const double log_likelihood = share * std::max(-inverse * d2, std::log(other));
    evidence.log_likelihood += log_likelihood;
    if (d2 > matched2 && !is_free) {
      evidence.unknown += share;
      continue;
    }
    evidence.known_log_likelihood += log_likelihood;
    (d2 <= matched2 ? evidence.matched : evidence.free) += share;
  }
  return evidence;
}

}  // namespace enfilade::localization
