// SPDX-License-Identifier: Apache-2.0
#include "core/geometry/covariance.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>
#include <random>

#include "core/geometry/pose_codec.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"

namespace enfilade {
namespace {

using ::testing::HasSubstr;
using testing::PoseNear;

Eigen::Matrix3d Spread(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  Eigen::Matrix3d factor;
  for (int i = 0; i < 9; ++i) factor.data()[i] = 0.1 * normal(random);
  return factor * factor.transpose();
}

PoseWithCovariance RandomPose(std::mt19937_64& random) {
  std::uniform_real_distribution<double> coordinate(-20.0, 20.0);
  std::uniform_real_distribution<double> yaw(-M_PI, M_PI);
  return {{coordinate(random), coordinate(random), yaw(random)}, Spread(random)};
}

TEST(ValidateCovariance, AcceptsPositiveSemiDefiniteMatrices) {
  EXPECT_OK(ValidateCovariance(Eigen::Matrix3d::Zero()));
  EXPECT_OK(ValidateCovariance(Eigen::Matrix3d::Identity()));
  EXPECT_OK(ValidateCovariance(Eigen::Matrix3d::Ones()));  // rank 1
  EXPECT_OK(ValidateCovariance(1e-18 * Eigen::Matrix3d::Identity()));
  EXPECT_OK(ValidateCovariance(1e18 * Eigen::Matrix3d::Identity()));
  std::mt19937_64 random(1);
  for (int i = 0; i < 200; ++i) EXPECT_OK(ValidateCovariance(Spread(random)));
}

TEST(ValidateCovariance, ToleratesRoundingOnly) {
  Eigen::Matrix3d rounded = Eigen::Matrix3d::Identity();
  rounded(0, 1) = 0.5;
  rounded(1, 0) = 0.5 + 1e-12;
  EXPECT_OK(ValidateCovariance(rounded));
  rounded(1, 0) = 0.5 + 1e-6;
  EXPECT_STATUS(ValidateCovariance(rounded), absl::StatusCode::kInvalidArgument, HasSubstr("symmetric"));
  EXPECT_OK(ValidateCovariance(Eigen::Vector3d(1.0, 1.0, -1e-12).asDiagonal()));
  EXPECT_STATUS(ValidateCovariance(Eigen::Vector3d(1.0, 1.0, -1e-6).asDiagonal()), absl::StatusCode::kInvalidArgument,
                HasSubstr("eigenvalue"));
}

TEST(ValidateCovariance, NamesTheProperty) {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    for (int element = 0; element < 9; ++element) {
      Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
      matrix.data()[element] = bad;
      EXPECT_STATUS(ValidateCovariance(matrix), absl::StatusCode::kInvalidArgument, HasSubstr("not finite"));
    }
  }
  Eigen::Matrix3d indefinite = Eigen::Matrix3d::Identity();
  indefinite(0, 2) = indefinite(2, 0) = 1.5;
  EXPECT_STATUS(ValidateCovariance(indefinite), absl::StatusCode::kInvalidArgument, HasSubstr("-0.5"));
}

TEST(ValidateMeasuredCovariance, RefusesVariancesThatNoMeasurementHas) {
  EXPECT_OK(ValidateMeasuredCovariance(kMaxVariance * Eigen::Matrix3d::Identity()));
  EXPECT_STATUS(ValidateMeasuredCovariance(Eigen::Vector3d(1.0, 1e300, 1.0).asDiagonal()),
                absl::StatusCode::kInvalidArgument, HasSubstr("1e+300"));
  EXPECT_CODE(ValidateMeasuredCovariance(-Eigen::Matrix3d::Identity()), absl::StatusCode::kInvalidArgument);
}

TEST(PoseWithCovariance, CompositionIsAssociative) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 200; ++i) {
    const PoseWithCovariance a = RandomPose(random);
    const PoseWithCovariance b = RandomPose(random);
    const PoseWithCovariance c = RandomPose(random);
    const PoseWithCovariance left = Compose(Compose(a, b), c);
    const PoseWithCovariance right = Compose(a, Compose(b, c));
    EXPECT_THAT(left.pose, PoseNear(right.pose, 1e-9, 1e-9));
    EXPECT_TRUE(left.covariance.isApprox(right.covariance, 1e-9)) << i;
  }
}

TEST(PoseWithCovariance, InversionIsAnInvolutionAndReversesCompositions) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 200; ++i) {
    const PoseWithCovariance a = RandomPose(random);
    const PoseWithCovariance b = RandomPose(random);
    EXPECT_THAT(Inverse(Inverse(a)).pose, PoseNear(a.pose, 1e-9, 1e-9));
    EXPECT_TRUE(Inverse(Inverse(a)).covariance.isApprox(a.covariance, 1e-9)) << i;
    const PoseWithCovariance left = Inverse(Compose(a, b));
    const PoseWithCovariance right = Compose(Inverse(b), Inverse(a));
    EXPECT_THAT(left.pose, PoseNear(right.pose, 1e-9, 1e-9));
    EXPECT_TRUE(left.covariance.isApprox(right.covariance, 1e-9)) << i;
  }
}

TEST(PoseWithCovariance, ResultsStayPositiveSemiDefinite) {
  std::mt19937_64 random(4);
  PoseWithCovariance chain;
  for (int i = 0; i < 100; ++i) {
    chain = i % 3 == 0 ? Inverse(Compose(chain, RandomPose(random))) : Compose(RandomPose(random), chain);
    EXPECT_OK(ValidateCovariance(0.5 * (chain.covariance + chain.covariance.transpose()))) << i;
  }
}

TEST(PoseWithCovariance, AnExactPoseOnlyRotatesAndLeversTheCovariance) {
  const PoseWithCovariance exact{{5.0, -2.0, M_PI / 2.0}, Eigen::Matrix3d::Zero()};
  const PoseWithCovariance uncertain{{1.0, 0.0, 0.0}, Eigen::Vector3d(4.0, 1.0, 0.01).asDiagonal()};
  // On the left it turns x into y.
  const PoseWithCovariance turned = Compose(exact, uncertain);
  EXPECT_TRUE(turned.covariance.isApprox(Eigen::Matrix3d(Eigen::Vector3d(1.0, 4.0, 0.01).asDiagonal()), 1e-12));
  // On the right the yaw's variance acts at the distance of its translation, sqrt(29) m.
  const PoseWithCovariance levered = Compose(uncertain, exact);
  EXPECT_NEAR(levered.covariance(0, 0) + levered.covariance(1, 1), 5.0 + 0.01 * 29.0, 1e-12);
  EXPECT_NEAR(levered.covariance(2, 2), 0.01, 1e-15);
}

TEST(PoseCodec, RestoresPosesAndMatricesExactly) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 20; ++i) {
    const PoseWithCovariance pose = RandomPose(random);
    std::string bytes;
    BinaryWriter writer(bytes);
    PutPose(writer, pose.pose);
    PutMatrix(writer, pose.covariance);
    EXPECT_EQ(bytes.size(), 12 * sizeof(double));
    BinaryReader reader(bytes);
    EXPECT_EQ(GetPose(reader), pose.pose);
    EXPECT_EQ(GetMatrix(reader), pose.covariance);
    EXPECT_TRUE(reader.at_end());
  }
}

TEST(Pose2Properties, FormAGroup) {
  std::mt19937_64 random(6);
  for (int i = 0; i < 500; ++i) {
    const Pose2 a = RandomPose(random).pose;
    const Pose2 b = RandomPose(random).pose;
    const Pose2 c = RandomPose(random).pose;
    EXPECT_THAT((a * b) * c, PoseNear(a * (b * c), 1e-9, 1e-9));
    EXPECT_THAT(Inverse(a) * a, PoseNear(Pose2{}, 1e-9, 1e-9));
    EXPECT_THAT(a * Between(a, b), PoseNear(b, 1e-9, 1e-9));
    const Eigen::Vector2d p(c.x, c.y);
    EXPECT_LT(((a * b) * p - a * (b * p)).norm(), 1e-9);
    for (const double t : {0.0, 0.3, 1.0}) {
      const Pose2 between = Interpolate(a, b, t);
      EXPECT_NEAR((between.translation() - a.translation()).norm(), t * (b.translation() - a.translation()).norm(),
                  1e-9);
      EXPECT_NEAR(std::abs(WrapAngle(between.yaw - a.yaw)), t * std::abs(WrapAngle(b.yaw - a.yaw)), 1e-9);
    }
  }
}

}  // namespace
}  // namespace enfilade
