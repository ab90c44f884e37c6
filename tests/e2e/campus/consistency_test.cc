// SPDX-License-Identifier: Apache-2.0
#include "tests/e2e/campus/consistency.h"

#include <gtest/gtest.h>

#include <cmath>

namespace enfilade::testing {
namespace {

constexpr TimeNs kScanInterval = 200'000'000;

// A robot drives 20 m straight on: 10 m in map A, which is the root, and 10 m in map B, whose frame is 10 m farther.
class ConsistencyTest : public ::testing::Test {
 protected:
  ConsistencyTest() {
    truth_.robot = "r";
    client::MappedStretch a{"s1", "A", "A", Pose2{}, {}};
    client::MappedStretch b{"s2", "B", "B", Pose2{10.0, 0.0, 0.0}, {}};
    for (int i = 0; i <= 200; ++i) {
      const double x = 0.1 * i;
      truth_.poses.push_back({kScanInterval * i, Pose2{3.0, 4.0, 1.0} * Pose2{x, 0.0, 0.0}, "ground", "hall"});
      (i < 100 ? a : b).poses.push_back({kScanInterval * i, {i < 100 ? x : x - 10.0, 0.0, 0.0}});
    }
    state_.root = "A";
    state_.stretches["r"] = {a, b};
  }

  static PoseWithCovariance Pose(double x, double yaw, double sigma, double yaw_sigma) {
    const Eigen::Vector3d sigmas(sigma, sigma, yaw_sigma);
    return {{x, 0.0, yaw}, sigmas.cwiseAbs2().asDiagonal()};
  }

  DriveTruth truth_;
  MappedState state_;
};

TEST_F(ConsistencyTest, MeasuresErrorsInUnitsOfTheirCovariances) {
  state_.transforms.push_back({"A", "B", 1, Pose(10.2, 0.0, 0.1, 0.01)});   // two standard deviations
  state_.transforms.push_back({"A", "B", 2, Pose(10.0, 0.04, 0.1, 0.01)});  // four
  state_.poses["A"] = Pose(0.0, 0.0, 0.0, 0.0);
  state_.poses["B"] = Pose(10.1, 0.01, 0.1, 0.01);
  const GraphConsistency found = MeasureConsistency({truth_}, state_);
  EXPECT_EQ(found.joins.samples, 1);
  EXPECT_EQ(found.joins.inside, 1);
  EXPECT_NEAR(found.joins.mean_nees(), 4.0 / 3.0, 1e-6);
  EXPECT_NEAR(found.joins.rms(), 0.2, 1e-6);
  EXPECT_EQ(found.chains.samples, 1);
  EXPECT_EQ(found.chains.inside, 0);
  EXPECT_NEAR(found.chains.mean_nees(), 16.0 / 3.0, 1e-6);
  EXPECT_EQ(found.maps.samples, 1) << "the root is where it is";
  EXPECT_NEAR(found.maps.mean_nees(), 2.0 / 3.0, 1e-6);
}

TEST_F(ConsistencyTest, LeavesOutMapsWhoseTrueFrameIsNotKnown) {
  state_.transforms.push_back({"A", "C", 1, Pose(10.2, 0.0, 0.1, 0.01)});
  state_.stretches["r"].push_back({"s3", "C", "C", Pose2{}, {{kScanInterval, {}}}});
  state_.poses["C"] = Pose(10.1, 0.01, 0.1, 0.01);
  const GraphConsistency found = MeasureConsistency({truth_}, state_);
  EXPECT_EQ(found.joins.samples, 0);
  EXPECT_EQ(found.maps.samples, 0);
}

}  // namespace
}  // namespace enfilade::testing
