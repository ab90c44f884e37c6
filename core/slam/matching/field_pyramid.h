// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "core/slam/matching/likelihood_field.h"
#include "core/slam/matching/scan_matcher.h"
#include "core/slam/matching/search_table.h"
#include "core/slam/slam_options.h"
#include "core/slam/submaps/submap_grid.h"

namespace enfilade::slam {

// What a finished submap is matched by: its likelihood field at several resolutions, and the table for searching poses
// anywhere in it.
struct FieldPyramid {
  std::vector<LikelihoodField> levels;  // from the coarsest to the submap's own resolution
  SearchTable table;

  FieldPyramid(const SubmapGrid& grid, const PyramidOptions& options);

  // Bytes of memory held.
  std::size_t bytes() const;
};

// A finished submap, ready to be searched and matched.
struct SearchableSubmap {
  SubmapGrid grid;
  FieldPyramid pyramid;

  SearchableSubmap(SubmapGrid submap_grid, const PyramidOptions& options)
      : grid(std::move(submap_grid)), pyramid(grid, options) {}
};

struct PyramidMatch {
  MatchResult match;  // at the last level tried
  bool inliers_suffice = false;
  std::string reason;  // if they do not: which share is below which minimum at which resolution
};

// Refines `guess` level by level. Each level starts at the result of the one before, with a robust kernel as wide as
// the level's cells. Stops at a level with too few inliers. The required share of inliers goes linearly from
// `min_inliers_coarsest`, where a scan that belongs there fits even from a poor guess, to `min_inliers` at the finest
// level.
PyramidMatch MatchToPyramid(const FieldPyramid& pyramid, const std::vector<Eigen::Vector2d>& points, const Pose2& guess,
                            const PyramidOptions& options, const FieldMatchOptions& field);

}  // namespace enfilade::slam
