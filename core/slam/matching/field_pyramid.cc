// SPDX-License-Identifier: Apache-2.0
#include "core/slam/matching/field_pyramid.h"

#include <algorithm>
#include <cmath>

#include "fmt/format.h"

namespace enfilade::slam {
namespace {

constexpr int kReachInCells = 8;
constexpr int kMinReachInCells = 6;
constexpr int kPyramidLevels = 7;

// The level at which poses are searched: the coarsest with cells of at most `cell` (m).
std::size_t SearchLevel(const std::vector<LikelihoodField>& levels, double cell) {
  std::size_t level = 0;
  while (level + 1 < levels.size() && levels[level].resolution() > cell * 1.001) ++level;
  return level;
}

}  // namespace

FieldPyramid::FieldPyramid(const SubmapGrid& grid, const PyramidOptions& options)
    : table(options.search_sigma, kPyramidLevels) {
  const std::vector<Eigen::Vector2d> points = grid.OccupiedPoints();
  for (int level = options.levels - 1; level >= 0; --level) {
    const double resolution = grid.resolution() * (1 << level);
    levels.emplace_back(resolution, std::max(kReachInCells * resolution, kMinReachInCells * grid.resolution()));
    levels.back().Add(points);
  }
  const LikelihoodField& searched = levels[SearchLevel(levels, options.search_cell)];
  table.Update(searched, searched.window());
}

std::size_t FieldPyramid::bytes() const {
  std::size_t bytes = table.bytes();
  for (const LikelihoodField& level : levels) bytes += level.bytes();
  return bytes;
}

PyramidMatch MatchToPyramid(const FieldPyramid& pyramid, const std::vector<Eigen::Vector2d>& points, const Pose2& guess,
                            const PyramidOptions& options, const FieldMatchOptions& field) {
  PyramidMatch result;
  Pose2 pose = guess;
  const std::size_t count = pyramid.levels.size();
  for (std::size_t i = 0; i < count; ++i) {
    const LikelihoodField& level = pyramid.levels[i];
    FieldMatchOptions level_options = field;
    level_options.sigma = std::max(field.sigma, options.sigma_in_cells * level.resolution());
    level_options.matched_distance = std::max(field.matched_distance, options.inlier_cells * level.resolution());
    result.match = MatchToField(level, points, pose, {}, level_options);
    pose = result.match.T_submap_robot;
    const double rise = count > 1 ? static_cast<double>(i) / static_cast<double>(count - 1) : 1.0;
    const double floor = options.min_inliers_coarsest + rise * (options.min_inliers - options.min_inliers_coarsest);
    if (result.match.matched_share < floor) {
      result.reason = fmt::format("inlier share {:.2f} below {:.2f} at {} m", result.match.matched_share, floor,
                                  level.resolution());
      return result;
    }
  }
  result.inliers_suffice = true;
  return result;
}

}  // namespace enfilade::slam
