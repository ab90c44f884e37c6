// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/edge_error.h"

#include <gtest/gtest.h>

#include <cmath>

namespace enfilade::optimize {
namespace {

const Pose2 kFrom{1.2, -3.4, 2.9};
const Pose2 kTo{-0.6, 2.2, -2.5};
const EdgeMeasurement kMeasurement(Pose2{0.7, 1.9, -1.1});

// The definition in pose_graph.h, by composing poses: the measured pose's inverse times the predicted one.
TEST(EdgeError, IsThePredictionSeenFromTheMeasurement) {
  const Pose2 expected = Between(kMeasurement.T_from_to, Between(kFrom, kTo));
  const Eigen::Vector3d error = EdgeError(kFrom, kTo, kMeasurement);
  EXPECT_NEAR(error.x(), expected.x, 1e-12);
  EXPECT_NEAR(error.y(), expected.y, 1e-12);
  EXPECT_NEAR(error.z(), expected.yaw, 1e-12);
}

TEST(EdgeError, WrapsTheYaw) {
  const Eigen::Vector3d error = EdgeError({0, 0, -3.1}, {0, 0, 3.1}, EdgeMeasurement(Pose2{}));
  EXPECT_NEAR(error.z(), 6.2 - 2.0 * M_PI, 1e-12);
}

Pose2 Shifted(const Pose2& pose, int axis, double h) {
  return {pose.x + (axis == 0 ? h : 0.0), pose.y + (axis == 1 ? h : 0.0), pose.yaw + (axis == 2 ? h : 0.0)};
}

TEST(EdgeError, JacobiansAgreeWithFiniteDifferences) {
  const LinearizedEdge edge = LinearizeEdge(kFrom, kTo, kMeasurement);
  EXPECT_EQ(edge.error, EdgeError(kFrom, kTo, kMeasurement));
  constexpr double h = 1e-6;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d by_from = (EdgeError(Shifted(kFrom, axis, h), kTo, kMeasurement) -
                                     EdgeError(Shifted(kFrom, axis, -h), kTo, kMeasurement)) /
                                    (2.0 * h);
    const Eigen::Vector3d by_to = (EdgeError(kFrom, Shifted(kTo, axis, h), kMeasurement) -
                                   EdgeError(kFrom, Shifted(kTo, axis, -h), kMeasurement)) /
                                  (2.0 * h);
    EXPECT_LT((edge.J_from().col(axis) - by_from).norm(), 1e-8) << "axis " << axis;
    EXPECT_LT((edge.J_to.col(axis) - by_to).norm(), 1e-8) << "axis " << axis;
  }
}

}  // namespace
}  // namespace enfilade::optimize
