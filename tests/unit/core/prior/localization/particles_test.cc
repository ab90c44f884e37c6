// SPDX-License-Identifier: Apache-2.0
#include "core/prior/localization/particles.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/prior/localization/ndt_map.h"

namespace enfilade::prior {
namespace {

TEST(LowVarianceSampleTest, DrawsEachAboutAsOftenAsItWeighs) {
  EXPECT_THAT(LowVarianceSample({1, 0, 2, 1}, 8, 0.5), ::testing::ElementsAre(0U, 0U, 2U, 2U, 2U, 2U, 3U, 3U));
  EXPECT_THAT(LowVarianceSample({0, 0, 1}, 3, 0.0), ::testing::ElementsAre(2U, 2U, 2U));
}

// Fox 2003: chi squared's 99 % quantile with k - 1 degrees of freedom, divided by 2 epsilon.
TEST(KldCountTest, IsAQuantileOfChiSquared) {
  const PlanLocalizerOptions options;
  EXPECT_EQ(KldCount(1, options), 1U);
  EXPECT_NEAR(static_cast<double>(KldCount(11, options)), 23.21 / 0.1, 3);    // 10 degrees of freedom
  EXPECT_NEAR(static_cast<double>(KldCount(101, options)), 135.81 / 0.1, 3);  // 100
}

TEST(ResampledTest, ManyBinsNeedManyParticles) {
  PlanLocalizerOptions options;
  std::vector<PlanParticle> wide;
  std::vector<PlanParticle> narrow;
  for (int i = 0; i < 5000; ++i) {
    wide.push_back({{.x = 0.5 * (i % 200), .y = 0.5 * (i / 200)}, 1.0 / 5000});
    narrow.push_back({{.x = 0.2, .y = 0.2}, 1.0 / 5000});
  }
  EXPECT_EQ(Resampled(narrow, 5000, 0.5, options).size(), 500U);
  EXPECT_EQ(Resampled(wide, 5000, 0.5, options).size(), 5000U);
}

TEST(ModesOfTest, ParticlesFarApartAreTwoModesWithTheirMass) {
  std::vector<PlanParticle> particles;
  for (int i = 0; i < 100; ++i) {
    const double off = 0.002 * (i - 50);
    particles.push_back({{.x = 3 + off, .y = 2, .yaw = M_PI - 0.01 + 0.5 * off}, 0.7 / 100});
    particles.push_back({{.x = 13, .y = 2 + 2 * off, .yaw = 0.5}, 0.3 / 100});
  }
  const PlanLocalizerOptions options;
  const std::vector<PlanMode> modes = ModesOf(particles, 0, options);
  ASSERT_EQ(modes.size(), 2U);
  EXPECT_NEAR(modes[0].mass, 0.7, 1e-9);
  EXPECT_NEAR(modes[1].mass, 0.3, 1e-9);
  EXPECT_NEAR(modes[0].mean.x, 3, 0.01);
  EXPECT_NEAR(std::abs(modes[0].mean.yaw), M_PI, 0.03);  // not the mean of pi and -pi
  EXPECT_NEAR(modes[1].mean.y, 2, 0.01);
  EXPECT_LT(modes[0].covariance(1, 1), modes[0].covariance(0, 0));
  EXPECT_NEAR(modes[1].covariance(1, 1), 0.004 * 0.004 * 100 * 100 / 12 + options.sigma_floor * options.sigma_floor,
              1e-3);
}

TEST(ModesOfTest, MirroredPlacesAreModesOfTheirOwn) {
  std::vector<PlanParticle> particles;
  for (int i = 0; i < 10; ++i) {
    particles.push_back({{.x = 3.1, .mirrored = i % 2 == 0}, 0.1});
  }
  EXPECT_EQ(ModesOf(particles, 0, {}).size(), 2U);
}

TEST(NdtTest, ACellHasTheMeanAndCovarianceOfItsPoints) {
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 9; ++i) points.emplace_back(0.05 + 0.05 * i, 0.2 + 0.01 * (i % 3));  // along x
  points.emplace_back(3.2, 0.2);                                                           // alone
  const std::vector<NdtCell> cells = NdtOf(points, 0.5);
  ASSERT_EQ(cells.size(), 1U);
  EXPECT_EQ(cells[0].points, 9);
  EXPECT_NEAR(cells[0].mean.x(), 0.25, 1e-12);
  EXPECT_NEAR(cells[0].mean.y(), 0.21, 1e-12);
  EXPECT_NEAR(cells[0].covariance(0, 0), 0.05 * 0.05 * 60 / 8, 1e-9);
  EXPECT_NEAR(cells[0].covariance(1, 1), 0.01 * 0.01 * 6 / 8, 1e-6);
}

TEST(NdtTest, AStraightWallCanBeInverted) {
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 9; ++i) points.emplace_back(0.05 + 0.05 * i, 0.2);
  const std::vector<NdtCell> cells = NdtOf(points, 0.5);
  ASSERT_EQ(cells.size(), 1U);
  EXPECT_NEAR(cells[0].covariance(1, 1), kThinnest * cells[0].covariance(0, 0), 1e-9);
  EXPECT_NEAR(cells[0].covariance(0, 1), 0, 1e-9);
}

}  // namespace
}  // namespace enfilade::prior
