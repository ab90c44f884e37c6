// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace enfilade::geo {

// A place on the WGS84 ellipsoid, degrees.
struct LonLat {
  double longitude = 0.0;  // [-180, 180]
  double latitude = 0.0;   // [-90, 90]

  friend bool operator==(const LonLat&, const LonLat&) = default;
};

// The transverse Mercator projection of the WGS84 ellipsoid about a freely chosen origin, with scale 1 on the origin's
// meridian, in metres east and north of the origin. GeographicLib computes it by Krueger's series to the sixth order in
// the third flattening (Karney 2011, Transverse Mercator with an accuracy of a few nanometers, J. Geodesy 85).
// Conformal, so a site keeps its angles; 10 km from the meridian lengths are 1.2 mm per km too long. Within about
// 1000 km of the origin a round trip is accurate to nanometres. The origin must not be a pole.
class TransverseMercator {
 public:
  TransverseMercator() : TransverseMercator(LonLat{}) {}
  explicit TransverseMercator(const LonLat& origin);

  const LonLat& origin() const { return origin_; }
  Eigen::Vector2d Forward(const LonLat& place) const;
  LonLat Inverse(const Eigen::Vector2d& east_north) const;

 private:
  LonLat origin_;
  double north_of_equator_ = 0.0;  // of the origin, m
};

}  // namespace enfilade::geo
