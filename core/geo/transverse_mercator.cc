// SPDX-License-Identifier: Apache-2.0
#include "core/geo/transverse_mercator.h"

#include <GeographicLib/Constants.hpp>
#include <GeographicLib/TransverseMercator.hpp>

namespace enfilade::geo {
namespace {

// GeographicLib throws only from the constructor, if the ellipsoid is invalid; projecting never throws.
const GeographicLib::TransverseMercator& Wgs84() {
  static const GeographicLib::TransverseMercator projection(GeographicLib::Constants::WGS84_a(),
                                                            GeographicLib::Constants::WGS84_f(), 1.0);
  return projection;
}

}  // namespace

TransverseMercator::TransverseMercator(const LonLat& origin) : origin_(origin) {
  double east = 0.0;
  Wgs84().Forward(origin_.longitude, origin_.latitude, origin_.longitude, east, north_of_equator_);
}

Eigen::Vector2d TransverseMercator::Forward(const LonLat& place) const {
  Eigen::Vector2d east_north;
  Wgs84().Forward(origin_.longitude, place.latitude, place.longitude, east_north.x(), east_north.y());
  east_north.y() -= north_of_equator_;
  return east_north;
}

LonLat TransverseMercator::Inverse(const Eigen::Vector2d& east_north) const {
  LonLat place;
  Wgs84().Reverse(origin_.longitude, east_north.x(), east_north.y() + north_of_equator_, place.latitude,
                  place.longitude);
  return place;
}

}  // namespace enfilade::geo
