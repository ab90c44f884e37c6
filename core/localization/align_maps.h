// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "core/geometry/pose2.h"
#include "core/localization/alignable_map.h"
#include "core/localization/localization_options.h"
#include "core/localization/pose_search.h"

namespace enfilade::localization {

// Where one map is thought to lie in another, and how far off that may be.
struct AlignmentGuess {
  Pose2 T_a_b = {};
  double radius = 5.0;     // m
  double yaw_range = 0.5;  // rad, up to pi
};

struct MapAlignmentOptions {
  // --- The search.
  int search_points = 250;     // surface points of the map that is moved
  double point_spacing = 0.1;  // m between neighbouring points that are refined
  // Mean likelihood of the points, below which a place is not considered, and the same as a share of the best one's.
  double min_score = 0.1;
  double min_relative_score = 0.5;
  double place_distance = 0.4;  // m: of places nearer than this with directions nearer than place_angle,
  double place_angle = 0.15;    // rad: only the best is considered
  int max_places = 60;          // for each direction
  int max_expansions = 1'000'000;

  // --- When a place is accepted.
  double min_share = 0.75;    // of the surfaces that both maps know, on walls
  double min_matched = 4.0;   // m of wall, in each map
  double min_overlap = 2.0;   // m^2 of ground that both have seen free
  double min_rival_ratio = 1.5;
  // The best place contradicts so much less wall than a rival would, m in both maps together. Less may be by chance.
  double min_lead = 2.0;
  double max_sigma = 0.15;      // m, of the position in its least certain direction
  double max_yaw_sigma = 0.02;  // rad

  // --- How far a place that fits is from others that count as rivals.
  double same_distance = 0.25;  // m: places nearer to each other than this are the same
  double same_angle = 0.1;      // rad
  // A place where less wall matches than this share of the best place's counts as much worse as it is less.
  double rival_matched = 0.4;
  // Added to the share that does not match, in ratios: what chance leaves unmatched at the right place.
  double misfit_floor = 0.03;
  double slide = 0.3;  // m: shifted by this along its least certain direction, the map must fit much worse

  // --- The covariance. Standard deviations added to that of the match, for what it does not model: cells, the maps'
  // own errors.
  double sigma_floor = 0.02;  // m, at the middle of the overlap
  double yaw_floor = 0.004;   // rad
};

struct MapAlignment {
  bool accepted = false;
  std::string reason;                        // for people: why it is not, or what it rests on
  std::optional<PoseWithCovariance> T_a_b;   // the best place; unset: they nowhere fit
  double score = 0.0;                        // of the surfaces of b that a knows, the share on walls of a
  double overlap = 0.0;                      // m^2 of ground that both have seen free
  double rival_ratio = 0.0;                  // how many times as well it fits as the best other place; 0: there is none
  Eigen::Vector2d place_a = Eigen::Vector2d::Zero();  // m: in the middle of the overlap
};

// Where map b lies in map a by the walls that both have seen. All places around the guess, and around the guess turned
// by 180 degrees, where enough walls of one lie on walls of the other (FindPoses) are refined (slam::MatchToField) and
// compared both ways: walls on walls, seen from the same side, speak for a place, walls on free ground against it. The
// best is accepted if it is determined in all directions and no other place explains the maps nearly as well, be it far
// away, turned, or a little farther along the corridor. Maps of identical corridors are thus ambiguous.
//
// INVALID_ARGUMENT: a guess that is out of range. Errors of `keep_going` are passed on.
absl::StatusOr<MapAlignment> AlignMaps(const AlignableMap& a, const AlignableMap& b, const AlignmentGuess& guess,
                                       const MapAlignmentOptions& options, const KeepGoing& keep_going);

}  // namespace enfilade::localization
