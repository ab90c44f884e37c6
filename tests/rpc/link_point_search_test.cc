// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numbers>

#include "tests/rpc/link_point_fixture.h"

namespace enfilade::testing {
namespace {

using ::testing::ElementsAre;
using SearchStub = v1::LinkPointService::Stub;

TEST_F(LinkPointTest, FindsAroundAPoseWithinTheRadiusOfItsUncertainty) {
  ASSERT_OK(Create("near", {MakeAnchor("m", {0, 19, 0})}));
  ASSERT_OK(Create("far", {MakeAnchor("m", {21, 0, 0})}));
  v1::FindLinkPointsRequest request;
  request.set_parent("sites/s");
  v1::MapPose& pose = *request.mutable_pose_in_map();
  pose.set_map("sites/s/maps/m");
  pose.mutable_pose_map_robot()->mutable_pose();
  EXPECT_THAT(Find(request), ElementsAre("near"));
  // 20 m + 2 sqrt(5.991 lambda_max), with lambda_max = 0.25 m^2: 22.45 m.
  for (const double value : {0.25, 0.0, 0.0, 0.0, 0.01, 0.0, 0.0, 0.0, 0.001}) {
    pose.mutable_pose_map_robot()->add_covariance(value);
  }
  ASSERT_OK_AND_ASSIGN(const auto response, Call(&SearchStub::FindLinkPoints, request));
  EXPECT_NEAR(response.radius_m(), 20.0 + 2.0 * std::sqrt(5.991 * 0.25), 1e-12);
  ASSERT_EQ(response.found_size(), 2);
  EXPECT_DOUBLE_EQ(response.found(0).distance_m(), 19.0);
  EXPECT_DOUBLE_EQ(response.found(0).bearing_rad(), std::numbers::pi / 2);
  EXPECT_NEAR(response.found(0).mahalanobis_distance(), 19.0 / std::sqrt(0.01 + 0.0015), 1e-9);
  EXPECT_NEAR(response.found(1).mahalanobis_distance(), 21.0 / std::sqrt(0.25 + 0.0015), 1e-9);
  request.set_base_radius_m(1.0);
  EXPECT_THAT(Find(request), ElementsAre());

  request.mutable_point_world()->set_x(21.0);
  EXPECT_THAT(Find(request), ElementsAre("far", "near"));
  request.set_max_count(1);
  EXPECT_THAT(Find(request), ElementsAre("far"));
  request.set_radius_m(0.0);
  EXPECT_THAT(Find(request), ElementsAre("far"));
  request.set_radius_m(-1.0);
  EXPECT_CODE(Call(&SearchStub::FindLinkPoints, request), absl::StatusCode::kInvalidArgument);
}

TEST_F(LinkPointTest, InAMapWithoutAPlaceEverythingWithoutOneIsConsidered) {
  ASSERT_OK(Create("placed", {MakeAnchor("m", {0, 1, 0})}));
  ASSERT_OK(Create("alone", {MakeAnchor("lab", {0, 1, 0})}));
  v1::FindLinkPointsRequest request;
  request.set_parent("sites/s");
  request.mutable_pose_in_map()->set_map("sites/s/maps/lab");
  request.mutable_pose_in_map()->mutable_pose_map_robot()->mutable_pose();
  EXPECT_THAT(Find(request), ElementsAre("alone"));
  request.mutable_pose_in_map()->set_map("sites/s/maps/cellar");
  EXPECT_CODE(Call(&SearchStub::FindLinkPoints, request), absl::StatusCode::kNotFound);
  request.mutable_point_world();
  request.set_include_unplaced(true);
  EXPECT_THAT(Find(request), ElementsAre("placed", "alone"));
}

}  // namespace
}  // namespace enfilade::testing
