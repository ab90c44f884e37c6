// SPDX-License-Identifier: Apache-2.0
#include "core/slam/loops/loop_matching.h"

#include <Eigen/Dense>
#include <cmath>

#include "core/slam/loops/edge_information.h"
#include "core/slam/matching/correlative_matcher.h"
#include "core/slam/matching/local_matching.h"
#include "core/slam/matching/scan_points.h"
#include "core/slam/matching/wall_faces.h"
#include "fmt/format.h"

namespace enfilade::slam {
namespace {

SearchWindow WindowOf(const LoopCandidate& candidate, const Pose2& guess, const LoopOptions& options) {
  SearchWindow window;
  window.centre = guess;
  window.half_width = candidate.half_width;
  window.half_angle = candidate.half_angle;
  window.sigma_translation = candidate.half_width;
  window.sigma_yaw = candidate.half_angle;
  window.min_score = options.min_search_score;
  return window;
}

// Why a match must be rejected by what it says itself; empty if it need not be.
std::string FindFault(const Agreement& agreement, const MatchResult& match, double min_agreement,
                      const LoopOptions& options) {
  if (agreement.agreement() < min_agreement) {
    return fmt::format("{:.2f} of the hits lie in free space of the submap: agreement {:.2f} below {:.2f}",
                       agreement.contradicted_share, agreement.agreement(), min_agreement);
  }
  const double weakest = WeakestDirection(match.information);
  if (weakest > options.max_sigma) {
    return fmt::format("the position along the walls is known to {:.2f} m only, not to {:.2f} m", weakest,
                       options.max_sigma);
  }
  return "";
}

// Refines `found` without hits on the other faces of walls: they pull the scan through the wall. They are no inliers.
PyramidMatch MatchToFacesSeen(const SearchableSubmap& submap, const std::vector<Eigen::Vector2d>& points,
                              const PyramidMatch& found, const SlamOptions& options) {
  const LikelihoodField& field = submap.pyramid.levels.back();
  const double reach = options.local.field.matched_distance;
  const auto facing_at = [&](const Pose2& T_submap_robot) {
    return OnFacesSeen(submap.grid, field, points, T_submap_robot, reach);
  };
  const std::vector<Eigen::Vector2d> facing = facing_at(found.match.T_submap_robot);
  if (facing.size() == points.size()) return found;
  PyramidMatch refined =
      MatchToPyramid(submap.pyramid, facing, found.match.T_submap_robot, options.pyramid, options.local.field);
  if (!refined.inliers_suffice) return refined;
  const std::vector<Eigen::Vector2d> still_facing = facing_at(refined.match.T_submap_robot);
  const Agreement agreement = MeasureAgreement(submap.grid, field, still_facing, refined.match.T_submap_robot, reach);
  const double share = agreement.matched_share * agreement.hits / static_cast<double>(points.size());
  refined.match.matched_share = share;
  refined.inliers_suffice = share >= options.pyramid.min_inliers;
  if (!refined.inliers_suffice) {
    refined.reason = fmt::format("inlier share {:.2f} below {:.2f} without walls seen from their other side only",
                                 share, options.pyramid.min_inliers);
  }
  return refined;
}

// Whether a window is so large that another place in it may look like the one found.
bool MayBeAmbiguous(const LoopCandidate& candidate, const LoopOptions& options) {
  return candidate.half_width > options.ambiguity_distance || candidate.half_angle > options.ambiguity_angle;
}

// Searches once more, without the surroundings of `found`. Returns why `found` is ambiguous; empty if it is not.
std::string FindAmbiguity(const SearchTable& table, const std::vector<Eigen::Vector2d>& points,
                          const SearchResult& found, SearchWindow window, const LoopOptions& options) {
  window.excluded = found.pose;
  window.excluded_distance = options.ambiguity_distance;
  window.excluded_angle = options.ambiguity_angle;
  window.relevant_score = options.max_ambiguity * found.score;
  const SearchResult other = SearchPose(table, points, window);
  if (other.score <= window.relevant_score) return "";
  return fmt::format("another place {:.1f} m away scores {:.2f}, this one {:.2f}",
                     Between(found.pose, other.pose).translation().norm(), other.score, found.score);
}

}  // namespace

LoopMatch MatchLoop(const SearchableSubmap& submap, const std::vector<Eigen::Vector2d>& hits, const Pose2& guess,
                    const LoopCandidate& candidate, const SlamOptions& options) {
  const LoopOptions& loop = options.loop;
  const FieldPyramid& pyramid = submap.pyramid;
  LoopMatch result;
  result.T_submap_node = guess;
  const auto reject = [&result](std::string reason) {
    result.reason = std::move(reason);
    return result;
  };

  const std::vector<Eigen::Vector2d> points = Thinned(hits, options.local.point_spacing);
  if (points.size() < static_cast<std::size_t>(loop.min_points)) {
    return reject(fmt::format("{} points, fewer than {}", points.size(), loop.min_points));
  }

  const SearchWindow window = WindowOf(candidate, guess, loop);
  const std::vector<Eigen::Vector2d> searched = Subsampled(points, static_cast<std::size_t>(loop.search_points));
  const SearchResult found = SearchPose(pyramid.table, searched, window);
  result.score = found.score;
  if (found.score < loop.min_search_score) {
    return reject(fmt::format("nothing scores {:.2f} within {:.1f} m and {:.2f} rad", loop.min_search_score,
                              window.half_width, window.half_angle));
  }

  PyramidMatch refined = MatchToPyramid(pyramid, points, found.pose, options.pyramid, options.local.field);
  if (refined.inliers_suffice && candidate.seen_from_node) refined = MatchToFacesSeen(submap, points, refined, options);
  result.T_submap_node = refined.match.T_submap_robot;
  result.score = refined.match.matched_share;
  if (!refined.inliers_suffice) return reject(refined.reason);

  const Agreement agreement = MeasureAgreement(submap.grid, pyramid.levels.back(), points, result.T_submap_node,
                                               options.local.field.matched_distance);
  const double min_agreement = candidate.is_entry ? loop.min_entry_agreement : loop.min_agreement;
  std::string fault = FindFault(agreement, refined.match, min_agreement, loop);
  if (fault.empty() && MayBeAmbiguous(candidate, loop)) {
    fault = FindAmbiguity(pyramid.table, searched, found, window, loop);
  }
  if (!fault.empty()) return reject(std::move(fault));

  result.information = WithFloor(refined.match.information, loop.sigma_floor, loop.yaw_floor);
  result.accepted = true;
  result.reason = fmt::format("inlier share {:.2f}, agreement {:.2f}", result.score, agreement.agreement());
  return result;
}

}  // namespace enfilade::slam
