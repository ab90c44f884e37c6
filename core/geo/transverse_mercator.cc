// SPDX-License-Identifier: Apache-2.0
#include "core/geo/transverse_mercator.h"

#include <array>
#include <cmath>

namespace enfilade::geo {
namespace {

constexpr double kSemiMajor = 6378137.0;
constexpr double kFlattening = 1.0 / 298.257223563;
constexpr double n = kFlattening / (2.0 - kFlattening);
constexpr double n2 = n * n;
constexpr double n3 = n2 * n;
constexpr double n4 = n2 * n2;
constexpr double n5 = n4 * n;
constexpr double n6 = n3 * n3;
// The radius of the circle as long as the meridian ellipse (eq. 14).
constexpr double kRectifying = kSemiMajor / (1.0 + n) * (1.0 + n2 / 4.0 + n4 / 64.0 + n6 / 256.0);

using Series = std::array<double, 6>;
// eq. 35
constexpr Series kAlpha = {n / 2 - 2 * n2 / 3 + 5 * n3 / 16 + 41 * n4 / 180 - 127 * n5 / 288 + 7891 * n6 / 37800,
                           13 * n2 / 48 - 3 * n3 / 5 + 557 * n4 / 1440 + 281 * n5 / 630 - 1983433 * n6 / 1935360,
                           61 * n3 / 240 - 103 * n4 / 140 + 15061 * n5 / 26880 + 167603 * n6 / 181440,
                           49561 * n4 / 161280 - 179 * n5 / 168 + 6601661 * n6 / 7257600,
                           34729 * n5 / 80640 - 3418889 * n6 / 1995840,
                           212378941 * n6 / 319334400};
// eq. 36
constexpr Series kBeta = {n / 2 - 2 * n2 / 3 + 37 * n3 / 96 - n4 / 360 - 81 * n5 / 512 + 96199 * n6 / 604800,
                          n2 / 48 + n3 / 15 - 437 * n4 / 1440 + 46 * n5 / 105 - 1118711 * n6 / 3870720,
                          17 * n3 / 480 - 37 * n4 / 840 - 209 * n5 / 4480 + 5569 * n6 / 90720,
                          4397 * n4 / 161280 - 11 * n5 / 504 - 830251 * n6 / 7257600,
                          4583 * n5 / 161280 - 108847 * n6 / 3991680,
                          20648693 * n6 / 638668800};

double Radians(double degrees) { return degrees * M_PI / 180.0; }
double Degrees(double radians) { return radians * 180.0 / M_PI; }

// e^2 and e of the ellipsoid.
const double kEccentricitySquared = kFlattening * (2.0 - kFlattening);
const double kEccentricity = std::sqrt(kEccentricitySquared);

// The tangent of the conformal latitude from that of the geographic one (eqs. 7-9).
double ConformalTangent(double tau) {
  const double sigma = std::sinh(kEccentricity * std::atanh(kEccentricity * tau / std::hypot(1.0, tau)));
  return tau * std::hypot(1.0, sigma) - sigma * std::hypot(1.0, tau);
}

// Back, by Newton (eqs. 19-21).
double GeographicTangent(double conformal) {
  double tau = conformal / (1.0 - kEccentricitySquared);
  for (int i = 0; i < 8; ++i) {
    const double at = ConformalTangent(tau);
    const double step = (conformal - at) / std::hypot(1.0, at) * (1.0 + (1.0 - kEccentricitySquared) * tau * tau) /
                        ((1.0 - kEccentricitySquared) * std::hypot(1.0, tau));
    tau += step;
    if (!(std::abs(step) > 1e-16 * std::max(1.0, std::abs(tau)))) break;
  }
  return tau;
}

// East and north of the equator's point on the meridian.
Eigen::Vector2d Project(double latitude, double longitude_difference) {
  const double conformal = ConformalTangent(std::tan(latitude));
  const double c = std::cos(longitude_difference);
  const double xi = std::atan2(conformal, c);
  const double eta = std::asinh(std::sin(longitude_difference) / std::hypot(conformal, c));
  double north = xi;
  double east = eta;
  for (int j = 1; j <= 6; ++j) {
    const double alpha = kAlpha[static_cast<std::size_t>(j - 1)];
    north += alpha * std::sin(2 * j * xi) * std::cosh(2 * j * eta);
    east += alpha * std::cos(2 * j * xi) * std::sinh(2 * j * eta);
  }
  return {kRectifying * east, kRectifying * north};
}

double WrapDegrees(double degrees) {
  const double wrapped = std::remainder(degrees, 360.0);
  return wrapped == 180.0 ? -180.0 : wrapped;
}

}  // namespace

TransverseMercator::TransverseMercator(const LonLat& origin)
    : origin_(origin), north_of_equator_(Project(Radians(origin.latitude), 0.0).y()) {}

Eigen::Vector2d TransverseMercator::Forward(const LonLat& place) const {
  const double difference = Radians(WrapDegrees(place.longitude - origin_.longitude));
  return Project(Radians(place.latitude), difference) - Eigen::Vector2d(0.0, north_of_equator_);
}

LonLat TransverseMercator::Inverse(const Eigen::Vector2d& east_north) const {
  const double xi = (east_north.y() + north_of_equator_) / kRectifying;
  const double eta = east_north.x() / kRectifying;
  double xi_sphere = xi;
  double eta_sphere = eta;
  for (int j = 1; j <= 6; ++j) {
    const double beta = kBeta[static_cast<std::size_t>(j - 1)];
    xi_sphere -= beta * std::sin(2 * j * xi) * std::cosh(2 * j * eta);
    eta_sphere -= beta * std::cos(2 * j * xi) * std::sinh(2 * j * eta);
  }
  const double c = std::cos(xi_sphere);
  const double s = std::sinh(eta_sphere);
  const double conformal = std::sin(xi_sphere) / std::hypot(s, c);
  return {.longitude = WrapDegrees(origin_.longitude + Degrees(std::atan2(s, c))),
          .latitude = Degrees(std::atan(GeographicTangent(conformal)))};
}

}  // namespace enfilade::geo
