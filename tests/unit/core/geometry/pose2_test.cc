// SPDX-License-Identifier: Apache-2.0
#include "core/geometry/pose2.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "tests/support/pose_matchers.h"

namespace enfilade {
namespace {

using testing::PoseNear;

TEST(WrapAngle, StaysInHalfOpenInterval) {
  EXPECT_DOUBLE_EQ(WrapAngle(M_PI), -M_PI);
  EXPECT_DOUBLE_EQ(WrapAngle(-M_PI), -M_PI);
  EXPECT_NEAR(WrapAngle(7.0), 7.0 - 2.0 * M_PI, 1e-15);
  for (double angle = -100.0; angle < 100.0; angle += 0.37) {
    const double wrapped = WrapAngle(angle);
    EXPECT_GE(wrapped, -M_PI);
    EXPECT_LT(wrapped, M_PI);
    EXPECT_NEAR(std::remainder(angle - wrapped, 2.0 * M_PI), 0.0, 1e-12);
  }
}

TEST(Pose2, ComposesAsFrames) {
  const Pose2 T_a_b{1.0, 2.0, M_PI / 2.0};
  const Pose2 T_b_c{3.0, 0.0, M_PI / 4.0};
  EXPECT_THAT(T_a_b * T_b_c, PoseNear(Pose2{1.0, 5.0, 3.0 * M_PI / 4.0}, 1e-12, 1e-12));
  EXPECT_THAT(T_a_b * Inverse(T_a_b), PoseNear(Pose2{}, 1e-12, 1e-12));
  EXPECT_THAT(Between(T_a_b, T_a_b * T_b_c), PoseNear(T_b_c, 1e-12, 1e-12));
}

TEST(Pose2, InterpolatesYawAlongTheShorterArc) {
  const Pose2 pose = Interpolate({0, 0, 3.0}, {2, 4, -3.0}, 0.5);
  EXPECT_THAT(pose, PoseNear(Pose2{1, 2, M_PI}, 1e-12, 1e-9));
}

Eigen::Matrix3d SampleCovariance(const std::vector<Pose2>& samples, const Pose2& mean) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const Pose2& sample : samples) {
    const Eigen::Vector3d d(sample.x - mean.x, sample.y - mean.y, WrapAngle(sample.yaw - mean.yaw));
    sum += d * d.transpose();
  }
  return sum / static_cast<double>(samples.size());
}

class CovarianceTest : public ::testing::Test {
 protected:
  Pose2 Sample(const PoseWithCovariance& pose) {
    const Eigen::Matrix3d L = pose.covariance.llt().matrixL();
    const Eigen::Vector3d d = L * Eigen::Vector3d(normal_(rng_), normal_(rng_), normal_(rng_));
    return {pose.pose.x + d.x(), pose.pose.y + d.y(), pose.pose.yaw + d.z()};
  }

  const PoseWithCovariance first_{
      {1.0, -2.0, 0.7}, (Eigen::Matrix3d() << 4e-4, 1e-4, 2e-5, 1e-4, 9e-4, -3e-5, 2e-5, -3e-5, 1e-4).finished()};
  const PoseWithCovariance second_{{5.0, 3.0, -1.9},
                                   (Eigen::Matrix3d() << 1e-4, 0, 0, 0, 1e-3, 4e-5, 0, 4e-5, 2e-4).finished()};
  std::mt19937 rng_{42};
  std::normal_distribution<double> normal_;
};

TEST_F(CovarianceTest, CompositionAgreesWithMonteCarlo) {
  const PoseWithCovariance composed = Compose(first_, second_);
  std::vector<Pose2> samples;
  for (int i = 0; i < 100'000; ++i) samples.push_back(Sample(first_) * Sample(second_));
  const Eigen::Matrix3d expected = SampleCovariance(samples, composed.pose);
  EXPECT_LT((composed.covariance - expected).norm(), 0.03 * expected.norm());
}

TEST_F(CovarianceTest, InversionAgreesWithMonteCarlo) {
  const PoseWithCovariance inverse = Inverse(first_);
  std::vector<Pose2> samples;
  for (int i = 0; i < 100'000; ++i) samples.push_back(Inverse(Sample(first_)));
  const Eigen::Matrix3d expected = SampleCovariance(samples, inverse.pose);
  EXPECT_LT((inverse.covariance - expected).norm(), 0.03 * expected.norm());
}

}  // namespace
}  // namespace enfilade
