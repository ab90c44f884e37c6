// SPDX-License-Identifier: Apache-2.0
#include "core/slam/matching/local_matching.h"

#include <algorithm>
#include <cmath>

#include "core/slam/matching/scan_points.h"

namespace enfilade::slam {
namespace {

constexpr double kFieldReach = 0.5;  // m: farther points have no gradient
constexpr int kLocalSearchLevels = 5;
constexpr std::size_t kSearchPoints = 120;
constexpr double kMinWideScore = 0.5;  // mean likelihood
constexpr double kWider = 3.0;
constexpr int kMaxWidenings = 2;
// A pose outside of the predicted window is believed only if it fits this share of the scan better than the best pose
// within.
constexpr double kMinGain = 0.30;
// If less than this share of the scan contradicts the pose within, the pose outside must also be unmistakable.
constexpr double kTenable = 0.05;
constexpr double kUnmistakableShare = 0.9;
constexpr double kUnmistakableHits = 60;  // at least point_spacing apart

double Fit(const LocalMatch& match) { return match.agreement.matched_share - match.agreement.contradicted_share; }

// Whether to prefer `match`, from a wider window than the prediction allows, to `nearer`. If nothing contradicts
// `nearer` (the robot may be on ground not yet seen), the evidence for `match` must be overwhelming.
bool IsBetter(const LocalMatch& match, const LocalMatch& nearer, const LocalMatchOptions& options) {
  return IsSure(match, options) && Fit(match) > Fit(nearer) + kMinGain &&
         (nearer.agreement.contradicted_share >= kTenable || IsUnmistakable(match));
}

LocalMatch MatchFrom(const LocalMap& map, const std::vector<Eigen::Vector2d>& points, const Pose2& guess,
                     const PosePrior& prior, const LocalMatchOptions& options) {
  LocalMatch result;
  result.match = MatchToField(map.fields.field, points, guess, prior, options.field, SurfaceNormals(points));
  result.agreement =
      MeasureAgreement(map.grid, map.fields.field, points, result.match.T_submap_robot, options.field.matched_distance);
  result.good = result.agreement.matched_share >= options.min_matched_share &&
                result.agreement.agreement() >= options.min_agreement;
  return result;
}

LocalMatch MatchWithin(const LocalMap& map, const std::vector<Eigen::Vector2d>& points, const SearchWindow& window,
                       const PosePrior& prior, const LocalMatchOptions& options) {
  const SearchResult found = SearchPose(map.fields.table, Subsampled(points, kSearchPoints), window);
  if (found.score > 0.0) return MatchFrom(map, points, found.pose, prior, options);
  LocalMatch result;
  result.match.T_submap_robot = found.pose;
  result.agreement = MeasureAgreement(map.grid, map.fields.field, points, found.pose, options.field.matched_distance);
  return result;
}

}  // namespace

bool IsSure(const LocalMatch& match, const LocalMatchOptions& options) {
  return match.good && match.agreement.agreement() >= options.sure_agreement;
}

bool IsUnmistakable(const LocalMatch& match) {
  const Agreement& agreement = match.agreement;
  return agreement.matched_share >= kUnmistakableShare && agreement.hits * agreement.matched_share >= kUnmistakableHits;
}

LocalFields::LocalFields(double resolution, const LocalMatchOptions& options)
    : field(resolution, kFieldReach), table(options.search_sigma, kLocalSearchLevels) {}

void LocalFields::Update(const SubmapGrid& grid, const std::vector<grid::CellIndex>& changed) {
  if (changed.empty()) return;
  table.Update(field, field.Update(grid, changed));
}

void LocalFields::Rebuild(const SubmapGrid& grid) {
  std::vector<grid::CellIndex> cells;
  for (const auto& [key, hit] : grid.hits()) cells.push_back({key.second, key.first});
  Update(grid, cells);
}

Agreement MeasureAgreement(const SubmapGrid& grid, const LikelihoodField& field,
                           const std::vector<Eigen::Vector2d>& points, const Pose2& T_submap_robot,
                           double matched_distance) {
  Agreement agreement;
  agreement.hits = static_cast<int>(points.size());
  if (points.empty()) return agreement;
  const double share = 1.0 / static_cast<double>(points.size());
  for (const Eigen::Vector2d& p : points) {
    const Eigen::Vector2d q = T_submap_robot * p;
    if (field.At(q).squared_distance <= matched_distance * matched_distance) {
      agreement.matched_share += share;
    } else if (grid.IsFree(grid.log_odds().CellOf(q))) {
      agreement.contradicted_share += share;
    }
  }
  return agreement;
}

LocalMatch MatchLocally(const LocalMap& map, const std::vector<Eigen::Vector2d>& hits, const Pose2& T_submap_last,
                        const PredictedMotion& motion, const LocalMatchOptions& options) {
  const std::vector<Eigen::Vector2d> points = Thinned(hits, options.point_spacing);
  const Pose2 predicted = T_submap_last * motion.T_last_now;
  LocalMatch best;
  best.match.T_submap_robot = predicted;
  if (points.empty()) return best;
  double wider = 1.0;
  for (int widening = 0; widening <= kMaxWidenings && !IsSure(best, options); ++widening, wider *= kWider) {
    SearchWindow window;
    window.centre = predicted;
    window.sigma_translation = wider * motion.sigma_translation;
    window.sigma_yaw = wider * motion.sigma_yaw;
    window.half_width = std::min(options.window_sigmas * window.sigma_translation, options.max_half_width);
    window.half_angle = std::min(options.window_sigmas * window.sigma_yaw, M_PI);
    // In wide windows only a pose that would be believed is worth finding. This minimum bounds the cost of the search.
    if (widening > 0) window.min_score = kMinWideScore;
    const PosePrior prior{predicted, InformationOf(window.sigma_translation, window.sigma_yaw)};
    const LocalMatch match = MatchWithin(map, points, window, prior, options);
    if (widening == 0) {
      best = match;
      if (motion.by_odometry) continue;
      // The search scores points on ground not yet seen as misses and so favours standing still. The agreement ignores
      // them: constant velocity is preferred if it fits the known ground as well.
      const LocalMatch ahead = MatchFrom(map, points, predicted, prior, options);
      if (IsSure(ahead, options) && ahead.agreement.agreement() >= best.agreement.agreement()) best = ahead;
    } else if (IsBetter(match, best, options)) {
      best = match;
    }
  }
  if (!best.good) {
    best.match.T_submap_robot = predicted;
    best.match.information.setZero();
  }
  return best;
}

}  // namespace enfilade::slam
