// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "absl/status/statusor.h"
#include "core/geo/transverse_mercator.h"
#include "core/geometry/pose2.h"

namespace enfilade::geo {

// A place known in both frames.
struct SurveyPoint {
  LonLat place;
  Eigen::Vector2d p_world = Eigen::Vector2d::Zero();  // m, the site's world frame

  friend bool operator==(const SurveyPoint&, const SurveyPoint&) = default;
};

// Where a site's world frame lies on the earth: east_north - east_north_0 = scale R(yaw) (p_world - p_world_0) in the
// transverse Mercator projection about the control points' centre. All coordinates are double and relative to centres,
// so that a world frame with coordinates of the size of UTM's keeps its millimetres.
class Georeference {
 public:
  Georeference(const TransverseMercator& projection, const Eigen::Vector2d& east_north_0,
               const Eigen::Vector2d& p_world_0, double yaw, double scale);

  LonLat ToLonLat(const Eigen::Vector2d& p_world) const;
  Eigen::Vector2d ToWorld(const LonLat& place) const;
  // The direction of the world frame's x axis, counter-clockwise from east, rad.
  double yaw() const { return yaw_; }
  // Metres on the ground per metre of the world frame.
  double scale() const { return scale_; }

 private:
  TransverseMercator projection_;
  Eigen::Vector2d east_north_0_;
  Eigen::Vector2d p_world_0_;
  double yaw_ = 0.0;
  double scale_ = 1.0;
};

struct GeoreferenceOptions {
  // Rigid: a metre of the world frame is a metre on the ground; two points then say also whether they fit.
  bool estimate_scale = false;
  // Between the two control points farthest apart, in either frame, m.
  double min_extent_m = 1.0;
  // What the scale that fits best may differ from 1, whether it is used or not: points that are mixed up, or have
  // longitude and latitude exchanged, hardly ever are the right size.
  double max_scale_error = 0.1;
};

struct GeoreferenceFit {
  Georeference georeference;
  std::vector<double> residual_m =
      {};  // per control point: on the ground, between where it is and where the fit puts it
  double rms_m = 0.0;
  double best_scale = 1.0;  // whether it was used or not
};

// The least-squares fit (Umeyama 1991, for the plane). INVALID_ARGUMENT: fewer than two points, a number that is not
// finite, a latitude or longitude out of range or a pole, points too close together, or of another size in the two
// frames; or fitting better in a mirror, which means exchanged axes or points.
absl::StatusOr<GeoreferenceFit> FitGeoreference(const std::vector<SurveyPoint>& points,
                                                const GeoreferenceOptions& options = {});

}  // namespace enfilade::geo
