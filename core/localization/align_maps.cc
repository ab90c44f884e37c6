// SPDX-License-Identifier: Apache-2.0
#include "core/localization/align_maps.h"

#include <Eigen/Dense>
#include <algorithm>
#include <limits>
#include <set>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/localization/map_fit.h"
#include "core/slam/matching/scan_matcher.h"
#include "core/slam/matching/scan_points.h"

namespace enfilade::localization {
namespace {

constexpr double kMaxRadius = 20.0;  // m
constexpr double kSearchSpacing = 0.2;  // m between points that are searched
constexpr std::size_t kRefinedPoints = 1000;
constexpr std::size_t kFinalPoints = 5000;

// Of one in each square of `spacing` m.
std::vector<Eigen::Vector2d> Spread(const std::vector<Eigen::Vector2d>& points, double spacing) {
  std::set<std::pair<long, long>> taken;
  std::vector<Eigen::Vector2d> spread;
  for (const Eigen::Vector2d& p : points) {
    if (taken.emplace(std::lround(p.x() / spacing), std::lround(p.y() / spacing)).second) spread.push_back(p);
  }
  return spread;
}

std::vector<Eigen::Vector2d> PointsOfSurfaces(const std::vector<SurfacePoint>& surfaces) {
  std::vector<Eigen::Vector2d> points;
  for (const SurfacePoint& surface : surfaces) points.push_back(surface.point);
  return points;
}

Eigen::Vector2d MeanOf(const std::vector<Eigen::Vector2d>& points) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

std::vector<Eigen::Vector2d> Relative(const std::vector<Eigen::Vector2d>& points, const Eigen::Vector2d& origin) {
  std::vector<Eigen::Vector2d> relative;
  for (const Eigen::Vector2d& p : points) relative.push_back(p - origin);
  return relative;
}

// A map that is moved over another one, which lies still.
struct Moved {
  const AlignableMap* still;
  const AlignableMap* moved;
  Pose2 T_still_moved;                  // as guessed
  std::vector<Eigen::Vector2d> points;  // of the moved map, those that may lie on walls of the other
};

// The moved points that come to lie within the other's walls, dilated by `reach`.
std::vector<Eigen::Vector2d> PointsInReach(const AlignableMap& still, const AlignableMap& moved,
                                           const Pose2& T_still_moved, double reach) {
  Eigen::Vector2d lower = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d upper = -lower;
  for (const SurfacePoint& surface : still.surfaces()) {
    lower = lower.cwiseMin(surface.point);
    upper = upper.cwiseMax(surface.point);
  }
  std::vector<Eigen::Vector2d> points;
  for (const Eigen::Vector2d& p : Spread(PointsOfSurfaces(moved.surfaces()), kSearchSpacing)) {
    const Eigen::Vector2d q = T_still_moved * p;
    if ((q.array() >= lower.array() - reach).all() && (q.array() <= upper.array() + reach).all()) points.push_back(p);
  }
  return points;
}

struct Place {
  Pose2 T_a_b;
  MapFit fit;

  // m: what speaks for it, less what speaks against it.
  double weight() const { return fit.matched() - 2.0 * fit.contradicted(); }
};

slam::FieldMatchOptions MatchOptions(double sigma) {
  slam::FieldMatchOptions options;
  options.sigma = sigma;
  options.matched_distance = kOnWall;
  return options;
}

class Alignment {
 public:
  Alignment(const AlignableMap& a, const AlignableMap& b, const AlignmentGuess& guess,
            const MapAlignmentOptions& options, const KeepGoing& keep_going)
      : a_(a), b_(b), guess_(guess), options_(options), keep_going_(keep_going) {}

  absl::StatusOr<MapAlignment> Run() {
    MapAlignment alignment;
    if (a_.surfaces().empty() || b_.surfaces().empty()) {
      alignment.reason = fmt::format("map {} has no walls beside free ground", a_.surfaces().empty() ? "a" : "b");
      return alignment;
    }
    ENFILADE_ASSIGN_OR_RETURN(const std::vector<Pose2> found, Search());
    refined_points_ = slam::Subsampled(Spread(PointsOfSurfaces(b_.surfaces()), options_.point_spacing), kRefinedPoints);
    for (const Pose2& T_a_b : found) {
      ENFILADE_RETURN_IF_ERROR(keep_going_());
      Add(Refine(T_a_b));
    }
    if (places_.empty()) {
      alignment.reason = "nowhere near the guess do walls of both lie on each other: is it farther off?";
      return alignment;
    }
    const auto best = std::max_element(places_.begin(), places_.end(),
                                       [](const Place& x, const Place& y) { return x.weight() < y.weight(); });
    Judge(*best, alignment);
    return alignment;
  }

 private:
  // The smaller map is moved: more of its points lie on walls.
  Moved Choose() const {
    const double reach = guess_.radius + 2.0;
    Moved b_in_a{&a_, &b_, guess_.T_a_b, PointsInReach(a_, b_, guess_.T_a_b, reach)};
    Moved a_in_b{&b_, &a_, Inverse(guess_.T_a_b), PointsInReach(b_, a_, Inverse(guess_.T_a_b), reach)};
    return b_in_a.points.size() <= a_in_b.points.size() ? std::move(b_in_a) : std::move(a_in_b);
  }

  absl::StatusOr<std::vector<Pose2>> Search() const {
    Moved moved = Choose();
    if (moved.points.empty()) return std::vector<Pose2>();
    const Eigen::Vector2d pivot = MeanOf(moved.points);
    const std::vector<Eigen::Vector2d> points =
        slam::Subsampled(Relative(moved.points, pivot), static_cast<std::size_t>(options_.search_points));
    const Eigen::Vector2d centre = moved.T_still_moved * pivot;
    // The guess may be off by so much where the maps meet, or where their frames are.
    const Eigen::Vector2d lever = moved.moved == &b_ ? Eigen::Vector2d(centre - guess_.T_a_b.translation())
                                                     : Eigen::Vector2d(pivot - guess_.T_a_b.translation());
    const double radius = guess_.radius + std::min(guess_.radius, 2.0 * std::sin(0.5 * guess_.yaw_range) * lever.norm());
    LocalizationOptions search;
    search.min_score = options_.min_score;
    search.min_relative_score = options_.min_relative_score;
    search.mode_distance = options_.place_distance;
    search.mode_angle = options_.place_angle;
    search.max_modes = options_.max_places;
    search.max_expansions = options_.max_expansions;
    std::vector<Pose2> found;
    for (const double turn : {0.0, M_PI}) {
      const SearchArea area{centre, radius, moved.T_still_moved.yaw + turn, guess_.yaw_range, true};
      ENFILADE_ASSIGN_OR_RETURN(const FoundPoses poses,
                                FindPoses(moved.still->searchable(), points, area, search, keep_going_));
      for (const FoundPose& one : poses.poses) {
        const Pose2 T_still_moved = one.T_map_robot * Pose2{-pivot.x(), -pivot.y(), 0.0};
        found.push_back(moved.moved == &b_ ? T_still_moved : Inverse(T_still_moved));
      }
      if (guess_.yaw_range >= M_PI) break;  // all directions have been searched
    }
    return found;
  }

  Pose2 Refine(const Pose2& T_a_b) const {
    Pose2 refined = T_a_b;
    for (const double sigma : {0.15, 0.05}) {
      refined =
          slam::MatchToField(a_.searchable().walls(), refined_points_, refined, {}, MatchOptions(sigma)).T_submap_robot;
    }
    return refined;
  }

  bool IsSamePlace(const Pose2& x, const Pose2& y) const {
    const Eigen::Vector2d middle = MeanOf(refined_points_);
    return (x * middle - y * middle).norm() < options_.same_distance &&
           std::abs(WrapAngle(x.yaw - y.yaw)) < options_.same_angle;
  }

  void Add(const Pose2& T_a_b) {
    for (const Place& place : places_) {
      if (IsSamePlace(place.T_a_b, T_a_b)) return;
    }
    Place place{T_a_b, CompareMaps(a_, b_, T_a_b)};
    if (place.weight() > 0.0) places_.push_back(std::move(place));
  }

  // The surfaces of b that a has seen from the same side, near the walls of a.
  std::vector<Eigen::Vector2d> CommonSurfaces(const Pose2& T_a_b) const {
    std::vector<Eigen::Vector2d> points;
    for (const SurfacePoint& surface : b_.surfaces()) {
      if (!surface.open.isZero() && !IsSeenFromTheSameSide(a_, T_a_b, surface)) continue;
      if (a_.searchable().walls().At(T_a_b * surface.point).squared_distance > kOnWall * kOnWall) continue;
      points.push_back(surface.point);
    }
    return slam::Subsampled(points, kFinalPoints);
  }

  // The pose by all that both have seen, and its covariance.
  std::optional<PoseWithCovariance> Locate(const Pose2& T_a_b) const {
    Pose2 pose = T_a_b;
    std::vector<Eigen::Vector2d> points;
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    slam::MatchResult match;
    for (int round = 0; round < 3; ++round) {
      points = CommonSurfaces(pose);
      if (points.empty()) return std::nullopt;
      middle = MeanOf(points);
      match = slam::MatchToField(a_.searchable().walls(), Relative(points, middle),
                                 pose * Pose2{middle.x(), middle.y(), 0.0}, {}, MatchOptions(0.05));
      pose = match.T_submap_robot * Pose2{-middle.x(), -middle.y(), 0.0};
    }
    const Eigen::LDLT<Eigen::Matrix3d> information(match.information + 1e-6 * Eigen::Matrix3d::Identity());
    Eigen::Matrix3d covariance = information.solve(Eigen::Matrix3d::Identity());
    covariance = 0.5 * (covariance + covariance.transpose()).eval();
    covariance.diagonal() += Eigen::Vector3d(options_.sigma_floor * options_.sigma_floor,
                                             options_.sigma_floor * options_.sigma_floor,
                                             options_.yaw_floor * options_.yaw_floor);
    return Compose({match.T_submap_robot, covariance}, {Pose2{-middle.x(), -middle.y(), 0.0}, Eigen::Matrix3d::Zero()});
  }

  // What does not match; less wall than would have to match counts as unmatched.
  double Misfit(const MapFit& fit, const MapFit& best) const {
    const double enough = options_.rival_matched * best.matched();
    return 1.0 - fit.share() * std::min(1.0, enough > 0.0 ? fit.matched() / enough : 1.0);
  }

  // How many times as well the best place fits as a rival; 1 if that leads by too little wall.
  double RatioTo(const MapFit& rival, const MapFit& best) const {
    const double lead = Misfit(rival, best) * best.matched() - best.contradicted();
    const double ratio =
        (Misfit(rival, best) + options_.misfit_floor) / (Misfit(best, best) + options_.misfit_floor);
    return lead < options_.min_lead ? std::min(ratio, 1.0) : ratio;
  }

  void Judge(const Place& best, MapAlignment& alignment) const {
    alignment.T_a_b = Locate(best.T_a_b);
    if (!alignment.T_a_b) {
      alignment.reason = "no wall has been seen from the same side in both";
      return;
    }
    const MapFit fit = CompareMaps(a_, b_, alignment.T_a_b->pose);
    const CommonGround ground = CommonGroundOf(a_, b_, alignment.T_a_b->pose);
    alignment.score = fit.b_in_a.share();
    alignment.overlap = ground.area;
    alignment.place_a = ground.middle;
    const Pose2* rival = nullptr;
    for (const Place& place : places_) {
      if (&place == &best || IsSamePlace(place.T_a_b, alignment.T_a_b->pose)) continue;
      const double ratio = RatioTo(place.fit, fit);
      if (rival != nullptr && ratio >= alignment.rival_ratio) continue;
      alignment.rival_ratio = ratio;
      rival = &place.T_a_b;
    }
    alignment.reason = Objection(fit, alignment, rival);
    alignment.accepted = alignment.reason.empty();
    if (alignment.accepted) {
      alignment.reason = fmt::format("{:.0f} m of wall match, {:.1f} m do not", 0.5 * fit.matched(),
                                     0.5 * fit.contradicted());
    }
  }

  // Empty: none.
  std::string Objection(const MapFit& fit, const MapAlignment& alignment, const Pose2* rival) const {
    if (std::min(fit.b_in_a.matched, fit.a_in_b.matched) < options_.min_matched ||
        alignment.overlap < options_.min_overlap) {
      return fmt::format("they overlap too little: {:.1f} m of wall and {:.1f} m2 of ground", 0.5 * fit.matched(),
                         alignment.overlap);
    }
    if (fit.share() < options_.min_share) {
      return fmt::format("only {:.0f} % of the walls that both have seen match", 100.0 * fit.share());
    }
    if (const std::optional<std::string> slides = Slides(fit, *alignment.T_a_b)) return *slides;
    if (rival != nullptr && alignment.rival_ratio < options_.min_rival_ratio) {
      const Pose2 off = Between(alignment.T_a_b->pose, *rival);
      return fmt::format("ambiguous: they fit nearly as well {:.1f} m farther{}", off.translation().norm(),
                         std::abs(off.yaw) > 0.5 * M_PI ? " and turned round" : "");
    }
    return "";
  }

  // Whether the maps can be shifted along each other, as in a bare corridor.
  std::optional<std::string> Slides(const MapFit& fit, const PoseWithCovariance& T_a_b) const {
    // The covariance without the lever of the yaw: at the middle of what was matched.
    const Eigen::Vector2d middle = MeanOf(CommonSurfaces(T_a_b.pose));
    const PoseWithCovariance at_middle = Compose(T_a_b, {Pose2{middle.x(), middle.y(), 0.0}, Eigen::Matrix3d::Zero()});
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(at_middle.covariance.topLeftCorner<2, 2>());
    const double sigma = std::sqrt(axes.eigenvalues()[1]);
    const double yaw_sigma = std::sqrt(at_middle.covariance(2, 2));
    if (sigma > options_.max_sigma || yaw_sigma > options_.max_yaw_sigma) {
      return fmt::format("the walls do not fix it: they leave {:.2f} m and {:.1f} degrees open (standard deviations)",
                         sigma, yaw_sigma / kDegree);
    }
    for (const double step : {-options_.slide, options_.slide}) {
      const Eigen::Vector2d shift = step * axes.eigenvectors().col(1);
      const Pose2 shifted{T_a_b.pose.x + shift.x(), T_a_b.pose.y + shift.y(), T_a_b.pose.yaw};
      if (RatioTo(CompareMaps(a_, b_, shifted), fit) < options_.min_rival_ratio) {
        return fmt::format("ambiguous: they fit nearly as well shifted by {:.1f} m, as along a corridor", options_.slide);
      }
    }
    return std::nullopt;
  }

  const AlignableMap& a_;
  const AlignableMap& b_;
  const AlignmentGuess& guess_;
  const MapAlignmentOptions& options_;
  const KeepGoing& keep_going_;
  std::vector<Eigen::Vector2d> refined_points_;  // of b
  std::vector<Place> places_;                    // refined
};

absl::Status ValidateGuess(const AlignmentGuess& guess) {
  if (!IsFinite(guess.T_a_b)) return InvalidArgument("pose_a_b is not finite");
  if (!(guess.radius > 0.0 && guess.radius <= kMaxRadius)) {
    return InvalidArgument("radius_m is {}: expected more than 0 and at most {}", guess.radius, kMaxRadius);
  }
  if (!(guess.yaw_range > 0.0 && guess.yaw_range <= M_PI)) {
    return InvalidArgument("yaw_range_rad is {}: expected more than 0 and at most pi", guess.yaw_range);
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<MapAlignment> AlignMaps(const AlignableMap& a, const AlignableMap& b, const AlignmentGuess& guess,
                                       const MapAlignmentOptions& options, const KeepGoing& keep_going) {
  ENFILADE_RETURN_IF_ERROR(ValidateGuess(guess));
  return Alignment(a, b, guess, options, keep_going).Run();
}

}  // namespace enfilade::localization
