// SPDX-License-Identifier: Apache-2.0
#include "core/geo/georeference.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::geo {
namespace {

using Complex = std::complex<double>;
using Points = std::vector<Eigen::Vector2d>;

Eigen::Vector2d Mean(const Points& points) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& point : points) sum += point / static_cast<double>(points.size());
  return sum;
}

// The largest distance between two points.
double Extent(const Points& points) {
  double extent = 0.0;
  for (const Eigen::Vector2d& a : points) {
    for (const Eigen::Vector2d& b : points) extent = std::max(extent, (a - b).norm());
  }
  return extent;
}

absl::Status Check(const std::vector<SurveyPoint>& points) {
  if (points.size() < 2) return InvalidArgument("{} control points: at least two are needed", points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& [place, p_world] = points[i];
    if (!std::isfinite(place.longitude) || !std::isfinite(place.latitude) || !p_world.allFinite()) {
      return InvalidArgument("control point {} is not finite", i);
    }
    if (std::abs(place.longitude) > 180.0) {
      return InvalidArgument("control point {} has the longitude {}: it must lie in [-180, 180]", i, place.longitude);
    }
    if (std::abs(place.latitude) > 89.0) {
      return InvalidArgument("control point {} has the latitude {}: it must lie in [-89, 89]", i, place.latitude);
    }
  }
  return absl::OkStatus();
}

// The mean longitude and latitude; works across the antimeridian.
LonLat Centre(const std::vector<SurveyPoint>& points) {
  LonLat centre = points.front().place;
  const LonLat first = centre;
  for (const SurveyPoint& point : points) {
    const double weight = 1.0 / static_cast<double>(points.size());
    centre.longitude += weight * std::remainder(point.place.longitude - first.longitude, 360.0);
    centre.latitude += weight * (point.place.latitude - first.latitude);
  }
  centre.longitude = std::remainder(centre.longitude, 360.0);
  return centre;
}

// sum conj(world) * ground and its mirrored counterpart, over points relative to their means.
struct Correlation {
  Complex direct;
  Complex mirrored;
  double world = 0.0;  // sum |world|^2
};

Correlation Correlate(const Points& world, const Points& ground) {
  Correlation result;
  const Eigen::Vector2d world_0 = Mean(world);
  const Eigen::Vector2d ground_0 = Mean(ground);
  for (std::size_t i = 0; i < world.size(); ++i) {
    const Complex w(world[i].x() - world_0.x(), world[i].y() - world_0.y());
    const Complex g(ground[i].x() - ground_0.x(), ground[i].y() - ground_0.y());
    result.direct += std::conj(w) * g;
    result.mirrored += w * g;
    result.world += std::norm(w);
  }
  return result;
}

}  // namespace

Georeference::Georeference(const TransverseMercator& projection, const Eigen::Vector2d& east_north_0,
                           const Eigen::Vector2d& p_world_0, double yaw, double scale)
    : projection_(projection), east_north_0_(east_north_0), p_world_0_(p_world_0), yaw_(yaw), scale_(scale) {}

LonLat Georeference::ToLonLat(const Eigen::Vector2d& p_world) const {
  return projection_.Inverse(Pose2{east_north_0_.x(), east_north_0_.y(), yaw_} *
                             Eigen::Vector2d(scale_ * (p_world - p_world_0_)));
}

absl::StatusOr<GeoreferenceFit> FitGeoreference(const std::vector<SurveyPoint>& points,
                                                const GeoreferenceOptions& options) {
  ENFILADE_RETURN_IF_ERROR(Check(points));
  const TransverseMercator projection(Centre(points));
  Points world;
  Points ground;
  for (const SurveyPoint& point : points) {
    world.push_back(point.p_world);
    ground.push_back(projection.Forward(point.place));
  }
  const double world_extent = Extent(world);
  const double ground_extent = Extent(ground);
  if (!(std::min(world_extent, ground_extent) >= options.min_extent_m)) {
    return InvalidArgument(
        "the control points are {:.3f} m apart on the ground and {:.3f} m in the world frame: at least"
        " {} m are needed",
        ground_extent, world_extent, options.min_extent_m);
  }
  const Correlation correlation = Correlate(world, ground);
  const double best_scale = std::abs(correlation.direct) / correlation.world;
  if (std::abs(correlation.mirrored) > 1.01 * std::abs(correlation.direct)) {
    return InvalidArgument("the control points fit better mirrored: axes or points seem to be exchanged");
  }
  if (!(std::abs(best_scale - 1.0) <= options.max_scale_error)) {
    return InvalidArgument(
        "the control points are {:.4f} times as far apart on the ground as in the world frame: check"
        " that no two are mixed up and that longitude and latitude are not exchanged",
        best_scale);
  }
  GeoreferenceFit fit{.georeference = Georeference(projection, Mean(ground), Mean(world), std::arg(correlation.direct),
                                                   options.estimate_scale ? best_scale : 1.0),
                      .residual_m = {},
                      .best_scale = best_scale};
  double sum = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d put = projection.Forward(fit.georeference.ToLonLat(world[i]));
    fit.residual_m.push_back((put - ground[i]).norm());
    sum += fit.residual_m.back() * fit.residual_m.back();
  }
  fit.rms_m = std::sqrt(sum / static_cast<double>(points.size()));
  return fit;
}

}  // namespace enfilade::geo
