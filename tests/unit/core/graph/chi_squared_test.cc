// SPDX-License-Identifier: Apache-2.0
#include "core/graph/chi_squared.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/graph/search_radius.h"

namespace enfilade::graph {
namespace {

// Abramowitz and Stegun 1964, table 26.8.
TEST(ChiSquaredQuantile, AgreesWithTheTable) {
  struct Row {
    int degrees_of_freedom;
    double p500, p900, p950, p990, p999;
  };
  for (const Row& row :
       {Row{1, 0.454936, 2.70554, 3.84146, 6.63490, 10.828}, Row{2, 1.38629, 4.60517, 5.99147, 9.21034, 13.816},
        Row{3, 2.36597, 6.25139, 7.81473, 11.3449, 16.266}, Row{6, 5.34812, 10.6446, 12.5916, 16.8119, 22.458},
        Row{9, 8.34283, 14.6837, 16.9190, 21.6660, 27.877}, Row{30, 29.3360, 40.2560, 43.7729, 50.8922, 59.703}}) {
    const auto quantile = [&](double p) { return ChiSquaredQuantile(p, row.degrees_of_freedom); };
    EXPECT_NEAR(quantile(0.5), row.p500, 1e-4 * row.p500);
    EXPECT_NEAR(quantile(0.9), row.p900, 1e-4 * row.p900);
    EXPECT_NEAR(quantile(0.95), row.p950, 1e-4 * row.p950);
    EXPECT_NEAR(quantile(0.99), row.p990, 1e-4 * row.p990);
    EXPECT_NEAR(quantile(0.999), row.p999, 1e-4 * row.p999);
  }
  EXPECT_NEAR(ChiSquaredQuantile(0.95, 2), kChiSquared2Dof95, 5e-4);
}

TEST(ChiSquaredQuantile, RisesWithProbabilityAndDegreesOfFreedom) {
  for (int k = 1; k < 40; ++k) {
    double last = 0.0;
    for (const double p : {1e-6, 0.01, 0.3, 0.7, 0.99, 0.999999, 1.0 - 1e-12}) {
      const double quantile = ChiSquaredQuantile(p, k);
      EXPECT_GT(quantile, last) << p << ", " << k;
      EXPECT_LT(quantile, ChiSquaredQuantile(p, k + 1));
      last = quantile;
    }
  }
}

TEST(ErrorEllipse, HoldsNinetyFivePercentOfSamples) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  for (const double angle : {0.0, 0.7, -1.2}) {
    Eigen::Matrix2d R;
    R << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    covariance.topLeftCorner<2, 2>() = R * Eigen::Vector2d(4.0, 0.25).asDiagonal() * R.transpose();
    const ErrorEllipse ellipse = ErrorEllipse95(covariance);
    constexpr int kSamples = 20'000;
    int inside = 0;
    for (int i = 0; i < kSamples; ++i) {
      const Eigen::Vector2d p = R * Eigen::Vector2d(2.0 * normal(random), 0.5 * normal(random));
      const double along = p.x() * std::cos(ellipse.angle) + p.y() * std::sin(ellipse.angle);
      const double across = -p.x() * std::sin(ellipse.angle) + p.y() * std::cos(ellipse.angle);
      inside += std::pow(along / ellipse.semi_major_m, 2) + std::pow(across / ellipse.semi_minor_m, 2) <= 1.0 ? 1 : 0;
    }
    EXPECT_NEAR(inside, 0.95 * kSamples, 5.0 * std::sqrt(0.95 * 0.05 * kSamples)) << angle;
  }
}

TEST(ErrorEllipse, OfASingularCovarianceIsFlat) {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  EXPECT_EQ(ErrorEllipse95(covariance).semi_major_m, 0.0);
  covariance(0, 0) = covariance(1, 1) = covariance(0, 1) = covariance(1, 0) = 1.0;
  const ErrorEllipse line = ErrorEllipse95(covariance);
  EXPECT_NEAR(line.semi_major_m, std::sqrt(2.0 * 5.991), 1e-9);
  EXPECT_NEAR(line.semi_minor_m, 0.0, 1e-6);
  EXPECT_NEAR(std::abs(std::sin(line.angle - M_PI / 4.0)), 0.0, 1e-9);
}

}  // namespace
}  // namespace enfilade::graph
