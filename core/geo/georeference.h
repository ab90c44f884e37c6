// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "absl/status/statusor.h"
#include "core/geo/transverse_mercator.h"
#include "core/geometry/pose2.h"

namespace enfilade::geo {

// A control point: a place known in both frames.
struct SurveyPoint {
  LonLat place;
  Eigen::Vector2d p_world = Eigen::Vector2d::Zero();  // m, the site's world frame

  friend bool operator==(const SurveyPoint&, const SurveyPoint&) = default;
};

// The position of a site's world frame on the earth: east_north - east_north_0 = scale R(yaw) (p_world - p_world_0) in
// the transverse Mercator projection about the centre of the control points. Coordinates are relative to centres, so
// even a world frame with coordinates as large as UTM's keeps millimetre precision.
class Georeference {
 public:
  Georeference(const TransverseMercator& projection, const Eigen::Vector2d& east_north_0,
               const Eigen::Vector2d& p_world_0, double yaw, double scale);

  LonLat ToLonLat(const Eigen::Vector2d& p_world) const;
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
  // False: rigid, one metre of the world frame is one metre on the ground; then even two points have a residual.
  bool estimate_scale = false;
  // Between the two control points farthest apart, in either frame, m.
  double min_extent_m = 1.0;
  // Limit of |best scale - 1|, whether that scale is used or not: mixed-up points, or exchanged longitude and latitude,
  // hardly ever give the right size.
  double max_scale_error = 0.1;
};

struct GeoreferenceFit {
  Georeference georeference;
  std::vector<double> residual_m = {};  // per control point: distance on the ground from its fitted position
  double rms_m = 0.0;
  double best_scale = 1.0;  // whether used or not
};

// The least-squares fit in the plane (Umeyama 1991). INVALID_ARGUMENT: fewer than two points; a number that is not
// finite; a latitude or longitude out of range, or near a pole; points too close together, or of different extent in
// the two frames; points that fit better mirrored, which indicates exchanged axes or points.
absl::StatusOr<GeoreferenceFit> FitGeoreference(const std::vector<SurveyPoint>& points,
                                                const GeoreferenceOptions& options = {});

}  // namespace enfilade::geo
