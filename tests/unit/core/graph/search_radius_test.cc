// SPDX-License-Identifier: Apache-2.0
#include "core/graph/search_radius.h"

#include <gmock/gmock.h>

#include <cmath>
#include <vector>

#include "core/graph/link_point.h"

namespace enfilade::graph {
namespace {

using ::testing::DoubleNear;
using ::testing::Optional;

// map_manager's search radius beyond its base, for n straight transforms of length d, each with its constant
// variances.
TEST(SearchRadiusTest, GrowsWithTheChainAsTabulated) {
  struct Line {
    double length_m;
    std::vector<double> extra_m;
  };
  const std::vector<Line> table = {{10.0, {0.27, 2.71, 6.01, 10.05, 14.70}},
                                   {20.0, {0.27, 5.38, 12.00, 20.07, 29.38}},
                                   {50.0, {0.27, 13.41, 29.98, 50.16, 73.43}}};
  for (const Line& row : table) {
    const PoseWithCovariance step{{row.length_m, 0.0, 0.0}, DefaultTransformCovariance()};
    PoseWithCovariance chain = step;
    for (std::size_t n = 0; n < row.extra_m.size(); ++n) {
      if (n > 0) chain = Compose(chain, step);
      EXPECT_NEAR(SearchRadius(chain.covariance), 20.0 + row.extra_m[n], 0.005) << row.length_m << " m, " << n + 1;
    }
  }
}

TEST(SearchRadiusTest, TakesBaseAndFactor) {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  EXPECT_DOUBLE_EQ(SearchRadius(covariance, {.base_m = 5.0, .factor = 2.0}), 5.0);
  covariance(1, 1) = 4.0;
  EXPECT_NEAR(SearchRadius(covariance, {.base_m = 0.0, .factor = 1.0}), 2.0 * std::sqrt(5.991), 1e-12);
}

TEST(SearchRadiusTest, EllipseHasTheAxesOfTheCovariance) {
  const double angle = 0.6;
  Eigen::Matrix2d R;
  R << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
  covariance.topLeftCorner<2, 2>() = R * Eigen::Vector2d(9.0, 1.0).asDiagonal() * R.transpose();
  const ErrorEllipse ellipse = ErrorEllipse95(covariance);
  EXPECT_NEAR(ellipse.semi_major_m, 3.0 * std::sqrt(5.991), 1e-9);
  EXPECT_NEAR(ellipse.semi_minor_m, std::sqrt(5.991), 1e-9);
  EXPECT_NEAR(std::sin(ellipse.angle - angle), 0.0, 1e-9);
}

TEST(SearchRadiusTest, MahalanobisDistanceCountsBothUncertainties) {
  Eigen::Matrix3d a = Eigen::Vector3d(1.0, 9.0, 1.0).asDiagonal();
  Eigen::Matrix3d b = Eigen::Vector3d(3.0, 7.0, 1.0).asDiagonal();
  EXPECT_THAT(MahalanobisDistance({{0, 0, 0}, a}, {{4, 0, 0}, b}), Optional(DoubleNear(2.0, 1e-12)));
  EXPECT_THAT(MahalanobisDistance({{0, 0, 0}, a}, {{0, 4, 1}, b}), Optional(DoubleNear(1.0, 1e-12)));
  EXPECT_THAT(MahalanobisDistance({{1, 1, 0}, {}}, {{1, 1, 0}, {}}), Optional(0.0));
  EXPECT_EQ(MahalanobisDistance({{1, 1, 0}, Eigen::Matrix3d::Zero()}, {{1, 2, 0}, Eigen::Matrix3d::Zero()}),
            std::nullopt);
}

TEST(SearchRadiusTest, BearingIsSeenFromTheRobot) {
  EXPECT_NEAR(Bearing({1.0, 1.0, M_PI / 2}, {1.0, 3.0}), 0.0, 1e-12);
  EXPECT_NEAR(Bearing({1.0, 1.0, M_PI / 2}, {3.0, 1.0}), -M_PI / 2, 1e-12);
  EXPECT_NEAR(Bearing({0.0, 0.0, -3.0}, {-1.0, 0.1}), WrapAngle(std::atan2(0.1, -1.0) + 3.0), 1e-12);
}

}  // namespace
}  // namespace enfilade::graph
