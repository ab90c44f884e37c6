// SPDX-License-Identifier: Apache-2.0
#include "core/localization/alignment/align_maps.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/localization/alignment/map_fit.h"
#include "core/localization/alignment/map_places.h"
#include "core/slam/matching/scan_matcher.h"
#include "core/slam/matching/scan_points.h"

namespace enfilade::localization {
namespace {

constexpr double kMaxRadius = 20.0;  // m
constexpr std::size_t kFinalPoints = 5000;
constexpr int kFinalRounds = 3;

PoseWithCovariance At(const Eigen::Vector2d& point) { return {{point.x(), point.y(), 0.0}, Eigen::Matrix3d::Zero()}; }

// Judges places of map b in map a.
class PlaceJudge {
 public:
  PlaceJudge(const AlignableMap& a, const AlignableMap& b, const MapAlignmentOptions& options)
      : a_(a), b_(b), options_(options), middle_b_(MiddleOfSurfaces(b)) {}

  MapAlignment Judge(const MapPlace& best, const std::vector<MapPlace>& places) const {
    MapAlignment alignment;
    alignment.T_a_b = Locate(best.T_a_b);
    if (!alignment.T_a_b) {
      alignment.reason = "no wall has been seen from the same side in both";
      return alignment;
    }
    const MapFit fit = CompareMaps(a_, b_, alignment.T_a_b->pose);
    const CommonGround ground = CommonGroundOf(a_, b_, alignment.T_a_b->pose);
    alignment.score = fit.b_in_a.share();
    alignment.overlap = ground.area;
    alignment.place_a = ground.middle;
    const MapPlace* const rival = FindRival(fit, alignment.T_a_b->pose, places);
    if (rival != nullptr) alignment.rival_ratio = RatioTo(rival->fit, fit);
    alignment.reason = Objection(fit, alignment, rival);
    alignment.accepted = alignment.reason.empty();
    if (!alignment.accepted) return alignment;
    alignment.reason =
        fmt::format("{:.0f} m of wall match, {:.1f} m do not", 0.5 * fit.matched(), 0.5 * fit.contradicted());
    return alignment;
  }

 private:
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

  // The pose by all that both have seen, and its covariance. Unset if that is nothing.
  std::optional<PoseWithCovariance> Locate(const Pose2& T_a_b) const {
    Pose2 pose = T_a_b;
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    slam::MatchResult match;
    for (int round = 0; round < kFinalRounds; ++round) {
      std::vector<Eigen::Vector2d> points = CommonSurfaces(pose);
      if (points.empty()) return std::nullopt;
      middle = MeanOf(points);
      for (Eigen::Vector2d& point : points) point -= middle;
      match = slam::MatchToField(a_.searchable().walls(), points, pose * At(middle).pose, {}, {});
      pose = match.T_submap_robot * At(-middle).pose;
    }
    return Compose({match.T_submap_robot, CovarianceOf(match)}, At(-middle));
  }

  Eigen::Matrix3d CovarianceOf(const slam::MatchResult& match) const {
    const Eigen::Matrix3d information = match.information + 1e-6 * Eigen::Matrix3d::Identity();
    const Eigen::Matrix3d inverse = information.ldlt().solve(Eigen::Matrix3d::Identity());
    Eigen::Matrix3d covariance = 0.5 * (inverse + inverse.transpose());
    covariance.diagonal() +=
        Eigen::Vector3d(options_.sigma_floor * options_.sigma_floor, options_.sigma_floor * options_.sigma_floor,
                        options_.yaw_floor * options_.yaw_floor);
    return covariance;
  }

  // The share that does not match; wall that would have to match, and is not there, does not.
  double Misfit(const MapFit& fit, const MapFit& best) const {
    const double enough = options_.rival_matched * best.matched();
    return 1.0 - fit.share() * std::min(1.0, enough > 0.0 ? fit.matched() / enough : 1.0);
  }

  // How many times as well the best place fits as a rival; at most 1 if it leads by too little wall.
  double RatioTo(const MapFit& rival, const MapFit& best) const {
    const double lead = Misfit(rival, best) * best.matched() - best.contradicted();
    const double ratio = (Misfit(rival, best) + options_.misfit_floor) / (Misfit(best, best) + options_.misfit_floor);
    return lead < options_.min_lead ? std::min(ratio, 1.0) : ratio;
  }

  // The other place that fits best. Null: there is none.
  const MapPlace* FindRival(const MapFit& fit, const Pose2& T_a_b, const std::vector<MapPlace>& places) const {
    const MapPlace* rival = nullptr;
    for (const MapPlace& place : places) {
      if (IsSamePlace(place.T_a_b, T_a_b, middle_b_, options_)) continue;
      if (rival == nullptr || RatioTo(place.fit, fit) < RatioTo(rival->fit, fit)) rival = &place;
    }
    return rival;
  }

  // Why the place is not accepted. Empty: it is.
  std::string Objection(const MapFit& fit, const MapAlignment& alignment, const MapPlace* rival) const {
    if (std::min(fit.b_in_a.matched, fit.a_in_b.matched) < options_.min_matched ||
        alignment.overlap < options_.min_overlap) {
      return fmt::format("they overlap too little: {:.1f} m of wall and {:.1f} m2 of ground", 0.5 * fit.matched(),
                         alignment.overlap);
    }
    if (fit.share() < options_.min_share) {
      return fmt::format("only {:.0f} % of the walls that both have seen match", 100.0 * fit.share());
    }
    std::string slides = Slides(fit, *alignment.T_a_b);
    if (!slides.empty() || rival == nullptr || alignment.rival_ratio >= options_.min_rival_ratio) return slides;
    const Pose2 off = Between(alignment.T_a_b->pose * At(middle_b_).pose, rival->T_a_b * At(middle_b_).pose);
    return fmt::format("ambiguous: they fit nearly as well {:.1f} m farther{}", off.translation().norm(),
                       std::abs(off.yaw) > 0.5 * M_PI ? " and turned round" : "");
  }

  // Whether the maps can be shifted along each other, as in a bare corridor. Empty: they cannot.
  std::string Slides(const MapFit& fit, const PoseWithCovariance& T_a_b) const {
    const PoseWithCovariance at_middle = Compose(T_a_b, At(MeanOf(CommonSurfaces(T_a_b.pose))));
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
      if (RatioTo(CompareMaps(a_, b_, shifted), fit) >= options_.min_rival_ratio) continue;
      return fmt::format("ambiguous: they fit nearly as well shifted by {:.1f} m, as along a corridor", options_.slide);
    }
    return "";
  }

  const AlignableMap& a_;
  const AlignableMap& b_;
  const MapAlignmentOptions& options_;
  const Eigen::Vector2d middle_b_;
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
  MapAlignment none;
  if (a.surfaces().empty() || b.surfaces().empty()) {
    none.reason = fmt::format("map {} has no walls beside free ground", a.surfaces().empty() ? "a" : "b");
    return none;
  }
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<MapPlace> places, FindMapPlaces(a, b, guess, options, keep_going));
  if (places.empty()) {
    none.reason = "nowhere near the guess do walls of both lie on each other: is it farther off?";
    return none;
  }
  const auto best = std::max_element(places.begin(), places.end(),
                                     [](const MapPlace& x, const MapPlace& y) { return x.weight() < y.weight(); });
  return PlaceJudge(a, b, options).Judge(*best, places);
}

}  // namespace enfilade::localization
