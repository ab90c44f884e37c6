// SPDX-License-Identifier: Apache-2.0
#include "proto/convert/geometry.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/support/status_assertions.h"

namespace enfilade::convert {
namespace {

using ::testing::HasSubstr;

TEST(ProtoGeometryTest, PosesWithCovarianceComeBackUnchanged) {
  PoseWithCovariance pose{{1.5, -2.25, 3.0}, Eigen::Matrix3d::Zero()};
  pose.covariance << 4, 1, 0.5, 1, 3, 0.25, 0.5, 0.25, 2;
  ASSERT_OK_AND_ASSIGN(const PoseWithCovariance back, FromProto("pose", ToProto(pose)));
  EXPECT_EQ(back.pose, pose.pose);
  EXPECT_EQ(back.covariance, pose.covariance);
}

TEST(ProtoGeometryTest, NoCovarianceIsZero) {
  v1::PoseWithCovariance message;
  message.mutable_pose()->set_x(1.0);
  ASSERT_OK_AND_ASSIGN(const PoseWithCovariance pose, FromProto("pose", message));
  EXPECT_TRUE(pose.covariance.isZero(0.0));
}

TEST(ProtoGeometryTest, RefusesWhatIsNoPoseWithCovarianceNamingTheField) {
  v1::PoseWithCovariance message;
  const auto refused = [&message](const char* why) {
    EXPECT_STATUS(FromProto("anchor.pose", message), absl::StatusCode::kInvalidArgument, HasSubstr(why));
  };
  refused("anchor.pose.pose is missing");
  message.mutable_pose()->set_yaw(std::nan(""));
  refused("not finite");
  message.mutable_pose()->set_yaw(0.0);
  message.add_covariance(1.0);
  refused("1 numbers");
  SetMatrix(-Eigen::Matrix3d::Identity(), message.mutable_covariance());
  refused("semi-definite");
}

TEST(ProtoGeometryTest, TakesEveryCovarianceThatIsOne) {
  std::mt19937 random(7);
  std::normal_distribution<double> number;
  for (int i = 0; i < 200; ++i) {
    Eigen::Matrix3d root;
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) root(row, column) = number(random);
    }
    if (i % 3 == 0) root.col(2).setZero();  // singular ones, too
    const PoseWithCovariance pose{{number(random), number(random), number(random)}, root * root.transpose()};
    ASSERT_OK_AND_ASSIGN(const PoseWithCovariance back, FromProto("pose", ToProto(pose)));
    EXPECT_EQ(back.covariance, pose.covariance);
  }
}

TEST(ProtoGeometryTest, RefusesAMatrixThatIsNoCovariance) {
  struct Case {
    const char* why;
    Eigen::Matrix3d matrix;
  };
  Eigen::Matrix3d asymmetric = Eigen::Matrix3d::Identity();
  asymmetric(0, 1) = 0.5;
  Eigen::Matrix3d negative = Eigen::Matrix3d::Identity();
  negative(2, 2) = -1e-3;
  Eigen::Matrix3d correlated = Eigen::Matrix3d::Identity();
  correlated(0, 1) = correlated(1, 0) = 1.5;  // more than 1
  Eigen::Matrix3d infinite = Eigen::Matrix3d::Identity();
  infinite(1, 1) = std::numeric_limits<double>::infinity();
  for (const Case& test : {Case{"asymmetric", asymmetric}, Case{"negative variance", negative},
                           Case{"correlation above 1", correlated}, Case{"infinite", infinite}}) {
    v1::PoseWithCovariance message;
    message.mutable_pose();
    SetMatrix(test.matrix, message.mutable_covariance());
    EXPECT_STATUS(FromProto("anchor.pose", message), absl::StatusCode::kInvalidArgument, HasSubstr("anchor.pose"))
        << test.why;
  }
}

}  // namespace
}  // namespace enfilade::convert
