// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/information.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <limits>
#include <random>

#include "tests/support/status_assertions.h"

namespace enfilade::optimize {
namespace {

using ::testing::HasSubstr;

TEST(CheckInformation, AcceptsPositiveDefiniteMatricesOfAnyScale) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (const double scale : {1e-12, 1.0, 1e12}) {
    for (int k = 0; k < 50; ++k) {
      Eigen::Matrix3d A;
      for (int i = 0; i < 9; ++i) A(i / 3, i % 3) = normal(random);
      const Eigen::Matrix3d information = scale * (A * A.transpose() + 0.01 * Eigen::Matrix3d::Identity());
      EXPECT_OK(CheckInformation(information));
    }
  }
}

// Inverting a matrix makes it asymmetric by rounding.
TEST(CheckInformation, ForgivesRoundingInTheSymmetry) {
  Eigen::Matrix3d information = 1e6 * Eigen::Matrix3d::Identity();
  information(0, 1) = 1e-4;
  EXPECT_OK(CheckInformation(information));
  information(0, 1) = 1e-2;
  EXPECT_STATUS(CheckInformation(information), absl::StatusCode::kInvalidArgument, HasSubstr("symmetric"));
}

TEST(CheckInformation, RejectsWhatIsNotFinite) {
  for (const double value : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    for (int i = 0; i < 9; ++i) {
      Eigen::Matrix3d information = Eigen::Matrix3d::Identity();
      information(i / 3, i % 3) = value;
      EXPECT_STATUS(CheckInformation(information), absl::StatusCode::kInvalidArgument, HasSubstr("not finite"));
    }
  }
}

TEST(CheckInformation, RejectsSingularAndIndefiniteMatrices) {
  const Eigen::Matrix3d zero = Eigen::Matrix3d::Zero();
  const Eigen::Matrix3d no_yaw = Eigen::Vector3d(1.0, 1.0, 0.0).asDiagonal();
  const Eigen::Matrix3d negative = -Eigen::Matrix3d::Identity();
  Eigen::Matrix3d saddle = Eigen::Matrix3d::Identity();
  saddle(0, 1) = saddle(1, 0) = 2.0;
  for (const Eigen::Matrix3d& information : {zero, no_yaw, negative, saddle}) {
    EXPECT_STATUS(CheckInformation(information), absl::StatusCode::kInvalidArgument, HasSubstr("positive definite"));
  }
}

}  // namespace
}  // namespace enfilade::optimize
