// SPDX-License-Identifier: Apache-2.0
#include "core/slam/loops/edge_information.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "core/optimize/edge_error.h"
#include "core/slam/matching/motion_model.h"

namespace enfilade::slam {
namespace {

Eigen::Matrix3d RandomInformation(std::mt19937& random) {
  std::normal_distribution<double> normal;
  Eigen::Matrix3d A;
  for (int i = 0; i < 9; ++i) A(i / 3, i % 3) = normal(random);
  return 100.0 * (A * A.transpose() + 0.1 * Eigen::Matrix3d::Identity());
}

TEST(WithFloor, AddsTheCovariances) {
  std::mt19937 random(1);
  const Eigen::Matrix3d floor = Eigen::Vector3d(0.04, 0.04, 0.0025).asDiagonal();
  for (int k = 0; k < 50; ++k) {
    const Eigen::Matrix3d information = RandomInformation(random);
    const Eigen::Matrix3d expected = (information.inverse() + floor).inverse();
    EXPECT_LT((WithFloor(information, 0.2, 0.05) - expected).norm(), 1e-3 * expected.norm());
  }
}

TEST(WithFloor, NeverSaysMoreThanBeforeNorThanTheFloor) {
  std::mt19937 random(2);
  const Eigen::Matrix3d floor = Eigen::Vector3d(1.0 / 0.01, 1.0 / 0.01, 1.0 / 0.0004).asDiagonal();
  for (int k = 0; k < 50; ++k) {
    const Eigen::Matrix3d information = RandomInformation(random);
    const Eigen::Matrix3d floored = WithFloor(information, 0.1, 0.02);
    const auto least = [](const Eigen::Matrix3d& M) {
      return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(M).eigenvalues()[0];
    };
    EXPECT_GT(least(floored), 0.0);
    EXPECT_GT(least(information + 1e-3 * Eigen::Matrix3d::Identity() - floored), -1e-6);
    EXPECT_GT(least(floor - floored), -1e-6);
    EXPECT_EQ(floored, Eigen::Matrix3d(floored.transpose()));
  }
}

TEST(WithFloor, MakesNothingPositiveDefinite) {
  const Eigen::Matrix3d floored = WithFloor(Eigen::Matrix3d::Zero(), 0.1, 0.02);
  EXPECT_EQ(Eigen::LLT<Eigen::Matrix3d>(floored).info(), Eigen::Success);
  EXPECT_LT(floored.norm(), 0.01) << "and still says nearly nothing";
}

// What the pose graph computes with the converted information is what the pose's information means.
TEST(InMeasurementFrame, KeepsTheChi2OfSmallErrors) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-3.0, 3.0);
  for (int k = 0; k < 50; ++k) {
    const Eigen::Matrix3d information = RandomInformation(random);
    const Pose2 T_a_b{any(random), any(random), any(random)};
    const Eigen::Vector3d off(1e-5 * any(random), 1e-5 * any(random), 1e-5 * any(random));
    const Pose2 T_a_other{T_a_b.x + off.x(), T_a_b.y + off.y(), T_a_b.yaw + off.z()};
    const double expected = off.dot(information * off);
    const Eigen::Vector3d e = optimize::EdgeError({}, T_a_other, optimize::EdgeMeasurement(T_a_b));
    EXPECT_NEAR(e.dot(InMeasurementFrame(information, T_a_b.yaw) * e), expected, 1e-4 * expected);
  }
}

TEST(InMeasurementFrame, TurnsThereAndBack) {
  std::mt19937 random(4);
  for (const double yaw : {0.0, 0.3, -1.7, M_PI}) {
    const Eigen::Matrix3d information = RandomInformation(random);
    const Eigen::Matrix3d back = InMeasurementFrame(InMeasurementFrame(information, yaw), -yaw);
    EXPECT_LT((back - information).norm(), 1e-12 * information.norm());
    EXPECT_NEAR(InMeasurementFrame(information, yaw).determinant(), information.determinant(),
                1e-9 * information.determinant());
  }
}

TEST(WeakestDirection, FindsTheDirectionWhateverTheFrame) {
  for (const double yaw : {0.0, 0.4, 1.2, -2.5}) {
    const Eigen::Matrix3d information = Eigen::Vector3d(1.0 / 0.0004, 1.0 / 0.09, 1e4).asDiagonal();
    EXPECT_NEAR(WeakestDirection(InMeasurementFrame(information, yaw)), 0.3, 1e-6) << yaw;
  }
}

// A yaw that is known badly makes the position uncertain if the two are correlated.
TEST(WeakestDirection, CountsWhatTheYawLeavesOpen) {
  Eigen::Matrix3d covariance = Eigen::Vector3d(0.01, 0.01, 0.01).asDiagonal();
  covariance(0, 2) = covariance(2, 0) = 0.009;
  const Eigen::Matrix3d information = covariance.inverse();
  EXPECT_NEAR(WeakestDirection(information), 0.1, 1e-6);
  EXPECT_LT(1.0 / std::sqrt(information(0, 0)), 0.05) << "with the yaw given it would be known better";
}

TEST(WeakestDirection, IsVastInACorridor) {
  Eigen::Matrix3d corridor = InformationOf(0.01, 0.001);
  corridor(0, 0) = 0.0;
  EXPECT_GT(WeakestDirection(corridor), 1'000.0);
  EXPECT_GT(WeakestDirection(Eigen::Matrix3d::Zero()), 1'000.0);
}

}  // namespace
}  // namespace enfilade::slam
