// SPDX-License-Identifier: Apache-2.0
#include "core/closure/pose_gate.h"

#include <cmath>

#include "gmock/gmock.h"

namespace enfilade::closure {
namespace {

using ::testing::DoubleNear;
using ::testing::Lt;

PoseWithCovariance Posed(double x, double y, double yaw, double sigma = 0.0, double yaw_sigma = 0.0) {
  PoseWithCovariance pose{{x, y, yaw}, Eigen::Matrix3d::Zero()};
  pose.covariance.diagonal() << sigma * sigma, sigma * sigma, yaw_sigma * yaw_sigma;
  return pose;
}

TEST(PoseGate, AddsBothCovariancesAndTheSigmas) {
  // 0.5^2 / (0.3^2 + 0.4^2 + 1.2^2) = 0.25 / 1.69
  EXPECT_THAT(PoseChiSquared(Posed(0, 0, 0, 0.3), Posed(0.5, 0, 0, 0.4), 1.2, 1.0), DoubleNear(0.25 / 1.69, 1e-12));
  // The orientation counts, too.
  EXPECT_THAT(PoseChiSquared(Posed(0, 0, 0), Posed(0, 0, 0.3), 1.0, 0.1), DoubleNear(9.0, 1e-9));
}

TEST(PoseGate, YawsAreComparedAroundTheCircle) {
  EXPECT_THAT(PoseChiSquared(Posed(0, 0, 3.1), Posed(0, 0, -3.1), 1.0, 1.0),
              DoubleNear(std::pow(2.0 * M_PI - 6.2, 2), 1e-9));
}

TEST(PoseGate, TakesAFullCovarianceAsItIs) {
  // Long along the diagonal: an error along it is likely, one across it is not.
  PoseWithCovariance long_one = Posed(0, 0, 0);
  long_one.covariance << 1.0, 0.99, 0.0, 0.99, 1.0, 0.0, 0.0, 0.0, 0.01;
  EXPECT_THAT(PoseChiSquared(long_one, Posed(1, 1, 0), 0.05, 0.1), Lt(1.1));
  EXPECT_GT(PoseChiSquared(long_one, Posed(1, -1, 0), 0.05, 0.1), 100.0);
}

TEST(PoseGate, ADoorHasNoFront) {
  const DoorClosureOptions options;
  const double same = PlaceChiSquared(Posed(3, 4, 0.2), Posed(3.1, 4, 0.25), options);
  EXPECT_THAT(PlaceChiSquared(Posed(3, 4, 0.2), Posed(3.1, 4, 0.25 + M_PI), options), DoubleNear(same, 1e-9));
  EXPECT_LT(same, Gate(options));
  EXPECT_GT(PlaceChiSquared(Posed(3, 4, 0.2), Posed(3.1, 4, 0.2 + M_PI / 2), options), Gate(options));
}

TEST(PoseGate, LetsDoorPosesThroughThatDifferAsRastersDo) {
  const DoorClosureOptions options;
  EXPECT_LT(PlaceChiSquared(Posed(0, 0, 0), Posed(0.5, 0, 0), options), Gate(options));
  EXPECT_GT(PlaceChiSquared(Posed(0, 0, 0), Posed(0.9, 0, 0), options),
            Gate(options));  // the next door is farther away
  EXPECT_LT(StrictGate(options), Gate(options));
}

}  // namespace
}  // namespace enfilade::closure
