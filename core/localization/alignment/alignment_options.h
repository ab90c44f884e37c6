// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/geometry/pose2.h"

namespace enfilade::localization {

// Where one map is thought to lie in another, and how far off that may be.
struct AlignmentGuess {
  Pose2 T_a_b = {};
  double radius = 5.0;     // m
  double yaw_range = 0.5;  // rad, up to pi
};

// How one map is fitted to another (AlignMaps).
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
  // Refined places nearer to each other than this are the same.
  double same_distance = 0.25;  // m
  double same_angle = 0.1;      // rad

  // --- When a place is accepted.
  double min_share = 0.75;       // of the surfaces that both maps know, on walls
  double min_matched = 4.0;      // m of wall, in each map
  double min_overlap = 2.0;      // m^2 of ground that both have seen free
  double min_rival_ratio = 1.5;  // how many times as well it fits as any other place
  double min_lead = 2.0;         // m of wall, in both maps, that a rival contradicts more: less may be by chance
  double max_sigma = 0.15;       // m, of the position in its least certain direction
  double max_yaw_sigma = 0.02;   // rad
  double rival_matched = 0.4;    // a rival with less matching wall than this share of the best place's counts less
  double misfit_floor = 0.03;    // added to what does not match, in ratios: by chance so much does not
  double slide = 0.3;            // m: shifted by this along its least certain direction, the map must fit much worse

  // --- Standard deviations added to those of the match, at the middle of the overlap, for what it does not model:
  // cells, and the errors of the maps themselves.
  double sigma_floor = 0.02;  // m
  double yaw_floor = 0.004;   // rad
};

}  // namespace enfilade::localization
