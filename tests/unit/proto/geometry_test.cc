// SPDX-License-Identifier: Apache-2.0
#include "proto/convert/geometry.h"

#include <gmock/gmock.h>

#include <cmath>

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

}  // namespace
}  // namespace enfilade::convert
