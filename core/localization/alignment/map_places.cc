// SPDX-License-Identifier: Apache-2.0
#include "core/localization/alignment/map_places.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "core/base/status_macros.h"
#include "core/slam/matching/scan_matcher.h"
#include "core/slam/matching/scan_points.h"

namespace enfilade::localization {
namespace {

constexpr double kSearchSpacing = 0.2;  // m between points that are searched
constexpr std::size_t kRefinedPoints = 1000;
constexpr double kBeyondWalls = 2.0;  // m: how far beyond the other map's walls a point may match by the guess

// The surfaces, one in each square of `spacing` m.
std::vector<Eigen::Vector2d> SpreadPoints(const AlignableMap& map, double spacing) {
  std::set<std::pair<long, long>> taken;
  std::vector<Eigen::Vector2d> spread;
  for (const SurfacePoint& surface : map.surfaces()) {
    const Eigen::Vector2d& p = surface.point;
    if (taken.emplace(std::lround(p.x() / spacing), std::lround(p.y() / spacing)).second) spread.push_back(p);
  }
  return spread;
}

// A map that is moved over another one, which lies still.
struct MovedMap {
  const AlignableMap* still;
  Pose2 T_still_moved;                  // as guessed
  std::vector<Eigen::Vector2d> points;  // of the moved map, those that may lie on walls of the other
  bool is_b = true;                     // the moved map is map b
};

MovedMap MoveOver(const AlignableMap& still, const AlignableMap& moved, const Pose2& T_still_moved, double reach) {
  Eigen::Vector2d lower = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d upper = -lower;
  for (const SurfacePoint& surface : still.surfaces()) {
    lower = lower.cwiseMin(surface.point);
    upper = upper.cwiseMax(surface.point);
  }
  MovedMap map{&still, T_still_moved, {}, true};
  for (const Eigen::Vector2d& p : SpreadPoints(moved, kSearchSpacing)) {
    const Eigen::Vector2d q = T_still_moved * p;
    if ((q.array() >= lower.array() - reach).all() && (q.array() <= upper.array() + reach).all()) {
      map.points.push_back(p);
    }
  }
  return map;
}

// The smaller map is moved: more of its points lie on walls.
MovedMap ChooseMoved(const AlignableMap& a, const AlignableMap& b, const AlignmentGuess& guess) {
  const double reach = guess.radius + kBeyondWalls;
  MovedMap b_in_a = MoveOver(a, b, guess.T_a_b, reach);
  MovedMap a_in_b = MoveOver(b, a, Inverse(guess.T_a_b), reach);
  a_in_b.is_b = false;
  return b_in_a.points.size() <= a_in_b.points.size() ? std::move(b_in_a) : std::move(a_in_b);
}

LocalizationOptions SearchOptions(const MapAlignmentOptions& options) {
  LocalizationOptions search;
  search.min_score = options.min_score;
  search.min_relative_score = options.min_relative_score;
  search.mode_distance = options.place_distance;
  search.mode_angle = options.place_angle;
  search.max_modes = options.max_places;
  search.max_expansions = options.max_expansions;
  return search;
}

// T_still_moved. The map is turned about `pivot`, the middle of its points.
absl::StatusOr<std::vector<Pose2>> SearchPlaces(const MovedMap& map, const Eigen::Vector2d& pivot,
                                                const AlignmentGuess& guess, const MapAlignmentOptions& options,
                                                const KeepGoing& keep_going) {
  std::vector<Eigen::Vector2d> points;
  for (const Eigen::Vector2d& p : map.points) points.push_back(p - pivot);
  points = slam::Subsampled(points, static_cast<std::size_t>(options.search_points));
  const Eigen::Vector2d centre = map.T_still_moved * pivot;
  // The guess may be off by the radius where the maps meet, or where the frame of b lies, and turned about that.
  const double lever = map.is_b ? pivot.norm() : (pivot - guess.T_a_b.translation()).norm();
  const double radius = guess.radius + 2.0 * std::sin(0.5 * guess.yaw_range) * lever;
  std::vector<Pose2> found;
  for (const double turn : {0.0, M_PI}) {
    const SearchArea area{centre, radius, map.T_still_moved.yaw + turn, guess.yaw_range, true};
    ENFILADE_ASSIGN_OR_RETURN(const FoundPoses poses,
                              FindPoses(map.still->searchable(), points, area, SearchOptions(options), keep_going));
    for (const FoundPose& one : poses.poses) found.push_back(one.T_map_robot * Pose2{-pivot.x(), -pivot.y(), 0.0});
    if (guess.yaw_range >= M_PI) break;  // all directions have been searched
  }
  return found;
}

Pose2 RefinePlace(const AlignableMap& a, const std::vector<Eigen::Vector2d>& points_b, const Pose2& T_a_b) {
  Pose2 refined = T_a_b;
  for (const double sigma : {0.15, 0.05}) {
    slam::FieldMatchOptions options;
    options.sigma = sigma;
    refined = slam::MatchToField(a.searchable().walls(), points_b, refined, {}, options).T_submap_robot;
  }
  return refined;
}

}  // namespace

Eigen::Vector2d MeanOf(const std::vector<Eigen::Vector2d>& points) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

Eigen::Vector2d MiddleOfSurfaces(const AlignableMap& map) { return MeanOf(SpreadPoints(map, kSearchSpacing)); }

bool IsSamePlace(const Pose2& T_a_b, const Pose2& other, const Eigen::Vector2d& middle_b,
                 const MapAlignmentOptions& options) {
  return (T_a_b * middle_b - other * middle_b).norm() < options.same_distance &&
         std::abs(WrapAngle(T_a_b.yaw - other.yaw)) < options.same_angle;
}

absl::StatusOr<std::vector<MapPlace>> FindMapPlaces(const AlignableMap& a, const AlignableMap& b,
                                                    const AlignmentGuess& guess, const MapAlignmentOptions& options,
                                                    const KeepGoing& keep_going) {
  std::vector<MapPlace> places;
  const MovedMap map = ChooseMoved(a, b, guess);
  if (map.points.empty()) return places;
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<Pose2> found,
                            SearchPlaces(map, MeanOf(map.points), guess, options, keep_going));
  const std::vector<Eigen::Vector2d> points_b =
      slam::Subsampled(SpreadPoints(b, options.point_spacing), kRefinedPoints);
  const Eigen::Vector2d middle_b = MeanOf(points_b);
  for (const Pose2& T_still_moved : found) {
    ENFILADE_RETURN_IF_ERROR(keep_going());
    const Pose2 T_a_b = RefinePlace(a, points_b, map.is_b ? T_still_moved : Inverse(T_still_moved));
    const bool is_known = std::any_of(places.begin(), places.end(), [&](const MapPlace& place) {
      return IsSamePlace(place.T_a_b, T_a_b, middle_b, options);
    });
    if (is_known) continue;
    MapPlace place{T_a_b, CompareMaps(a, b, T_a_b)};
    if (place.weight() > 0.0) places.push_back(std::move(place));
  }
  return places;
}

}  // namespace enfilade::localization
