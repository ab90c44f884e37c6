// SPDX-License-Identifier: Apache-2.0
#include "core/slam/loops/loop_matching.h"

#include <Eigen/Dense>
#include <cmath>

#include "core/slam/loops/edge_information.h"
#include "core/slam/matching/correlative_matcher.h"
#include "core/slam/matching/local_matching.h"
#include "core/slam/matching/scan_points.h"
#include "fmt/format.h"

namespace enfilade::slam {
LoopMatch MatchLoop(const SubmapGrid& grid, const FieldPyramid& pyramid, const std::vector<Eigen::Vector2d>& hits,
                    const Pose2& guess, const LoopCandidate& candidate, const SlamOptions& options) {
  const LoopOptions& loop = options.loop;
  LoopMatch result;
  result.T_submap_node = guess;
  const std::vector<Eigen::Vector2d> points = Thinned(hits, options.local.point_spacing);
  if (points.size() < static_cast<std::size_t>(loop.min_points)) {
    result.reason = fmt::format("{} points, fewer than {}", points.size(), loop.min_points);
    return result;
  }
  SearchWindow window;
  window.centre = guess;
  window.half_width = candidate.half_width;
  window.half_angle = candidate.half_angle;
  window.sigma_translation = candidate.half_width;
  window.sigma_yaw = candidate.half_angle;
  window.min_score = loop.min_search_score;
  const std::vector<Eigen::Vector2d> searched = Subsampled(points, static_cast<std::size_t>(loop.search_points));
  const SearchResult found = SearchPose(pyramid.table, searched, window);
  result.score = found.score;
  if (found.score < loop.min_search_score) {
    result.reason = fmt::format("nothing scores {:.2f} within {:.1f} m and {:.2f} rad", loop.min_search_score,
                                window.half_width, window.half_angle);
    return result;
  }
  const PyramidMatch refined = MatchToPyramid(pyramid, points, found.pose, options.pyramid, options.local.field);
  result.T_submap_node = refined.match.T_submap_robot;
  result.score = refined.match.matched_share;
  if (!refined.inliers_suffice) {
    result.reason = refined.reason;
    return result;
  }
  const Agreement agreement =
      MeasureAgreement(grid, pyramid.levels.back(), points, result.T_submap_node, options.local.field.matched_distance);
  const double min_agreement = candidate.is_entry ? loop.min_entry_agreement : loop.min_agreement;
  if (agreement.agreement() < min_agreement) {
    result.reason = fmt::format("{:.2f} of the hits lie in free space of the submap: agreement {:.2f} below {:.2f}",
                                agreement.contradicted_share, agreement.agreement(), min_agreement);
    return result;
  }
  const double weakest = WeakestDirection(refined.match.information);
  if (weakest > loop.max_sigma) {
    result.reason = fmt::format("the walls leave {:.2f} m open along them, more than {:.2f}", weakest, loop.max_sigma);
    return result;
  }
  if (candidate.half_width > loop.ambiguity_distance || candidate.half_angle > loop.ambiguity_angle) {
    window.excluded = found.pose;
    window.excluded_distance = loop.ambiguity_distance;
    window.excluded_angle = loop.ambiguity_angle;
    const SearchResult other = SearchPose(pyramid.table, searched, window);
    if (other.score > loop.max_ambiguity * found.score) {
      result.reason = fmt::format("another place {:.1f} m away scores {:.2f} beside {:.2f}",
                                  Between(found.pose, other.pose).translation().norm(), other.score, found.score);
      return result;
    }
  }
  result.information = WithFloor(refined.match.information, loop.sigma_floor, loop.yaw_floor);
  result.accepted = true;
  result.reason = fmt::format("inlier share {:.2f}, agreement {:.2f}", result.score, agreement.agreement());
  return result;
}

}  // namespace enfilade::slam
