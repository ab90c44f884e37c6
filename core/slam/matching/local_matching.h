// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/slam/matching/correlative_matcher.h"
#include "core/slam/matching/likelihood_field.h"
#include "core/slam/matching/motion_model.h"
#include "core/slam/matching/scan_matcher.h"
#include "core/slam/matching/search_table.h"
#include "core/slam/submaps/submap_grid.h"

namespace enfilade::slam {

// What the active submap is matched by. Kept up to date with its grid.
struct LocalFields {
  LikelihoodField field;
  SearchTable table;

  LocalFields(double resolution, const LocalMatchOptions& options);

  // Bytes of memory held.
  std::size_t bytes() const { return field.bytes() + table.bytes(); }

  // `changed`: what SubmapGrid::Insert returned.
  void Update(const SubmapGrid& grid, const std::vector<grid::CellIndex>& changed);
  // From scratch, into new fields: the same result as all updates together.
  void Rebuild(const SubmapGrid& grid);
};

// The active submap: its grid and the fields made of it.
struct LocalMap {
  const SubmapGrid& grid;
  const LocalFields& fields;
};

// How well a scan at a pose fits a grid.
struct Agreement {
  double matched_share = 0.0;       // share of hits with a wall within the matched distance
  double contradicted_share = 0.0;  // share of hits in known free space without a wall near
  int hits = 0;

  double known_share() const { return matched_share + contradicted_share; }
  double agreement() const { return known_share() > 0.0 ? matched_share / known_share() : 0.0; }
};
Agreement MeasureAgreement(const SubmapGrid& grid, const LikelihoodField& field,
                           const std::vector<Eigen::Vector2d>& points, const Pose2& T_submap_robot,
                           double matched_distance);

struct LocalMatch {
  MatchResult match;
  Agreement agreement;
  bool good = false;
};

// Whether the match is so good that no wider search is needed.
bool IsSure(const LocalMatch& match, const LocalMatchOptions& options);
// Whether nearly all of a scan with many hits fits: that does not happen by chance elsewhere.
bool IsUnmistakable(const LocalMatch& match);

// The scan's pose in the active submap: a correlative search about the predicted pose, in wider windows if a narrow one
// finds no sure match, refined by MatchToField along the scan's SurfaceNormals with the prediction as prior. If there
// is no good match the pose is the prediction and its information zero.
LocalMatch MatchLocally(const LocalMap& map, const std::vector<Eigen::Vector2d>& hits, const Pose2& T_submap_last,
                        const PredictedMotion& motion, const LocalMatchOptions& options);

}  // namespace enfilade::slam
