// SPDX-License-Identifier: Apache-2.0
// Commands for link points: what they ask for, and what they print.
#include <ctime>

#include "tests/unit/client/cli/server_commands_fixture.h"

namespace enfilade::cli {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class LinkPointCommandsTest : public ServerCommandsTest {
 protected:
  LinkPointCommandsTest() {
    server_.link_points.create = [this](const v1::CreateLinkPointRequest& request,
                                        v1::CreateLinkPointResponse& response) {
      created_ = request;
      *response.mutable_link_point() = request.link_point();
      response.mutable_link_point()->set_name("sites/s/linkPoints/new");
      return grpc::Status::OK;
    };
  }
  v1::CreateLinkPointRequest created_;
};

TEST_F(LinkPointCommandsTest, TwoPlacesMakeALinkPoint) {
  ASSERT_OK(
      Run({"linkpoint", "set", "--at", "Hall,1,2,0.5", "--at", "Lab,3,4", "--kind", "lift", "--tag", "A", "--force"}));
  EXPECT_EQ(created_.parent(), "sites/s");
  EXPECT_TRUE(created_.force());
  EXPECT_EQ(created_.link_point().kind(), v1::LinkPoint::KIND_LIFT);
  ASSERT_EQ(created_.link_point().anchors_size(), 2);
  EXPECT_EQ(created_.link_point().anchors(0).map(), "sites/s/maps/h");
  EXPECT_EQ(created_.link_point().anchors(0).pose_map_place().pose().yaw(), 0.5);
  EXPECT_EQ(created_.link_point().anchors(1).pose_map_place().pose().x(), 3.0);
  EXPECT_EQ(Printed()["candidate"], false);
  EXPECT_EQ(Printed()["kind"], "lift");
  EXPECT_CODE(Run({"linkpoint", "set", "--at", "Cellar,1,2", "--at", "Lab,3,4"}), absl::StatusCode::kNotFound);
}

TEST_F(LinkPointCommandsTest, OnePlaceAndAnIdPromoteACandidate) {
  v1::AddLinkPointAnchorRequest added;
  server_.link_points.add_anchor = [&](const v1::AddLinkPointAnchorRequest& request,
                                       v1::AddLinkPointAnchorResponse& response) {
    added = request;
    response.mutable_link_point()->set_name(request.name());
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"linkpoint", "set", "--id", "door", "--at", "Lab,3,4"}, false));
  EXPECT_EQ(added.name(), "sites/s/linkPoints/door");
  EXPECT_EQ(added.anchor().map(), "sites/s/maps/l");
  ASSERT_OK(Run({"linkpoint", "candidate", "--at", "Hall,1,2"}));
  EXPECT_EQ(Printed()["candidate"], true);
}

TEST_F(LinkPointCommandsTest, ListsAreFilteredByTheServer) {
  v1::ListLinkPointsRequest asked;
  server_.link_points.list = [&](const v1::ListLinkPointsRequest& request, v1::ListLinkPointsResponse& response) {
    asked = request;
    v1::LinkPoint& point = *response.add_link_points();
    point.set_name("sites/s/linkPoints/door");
    point.set_state(v1::LinkPoint::STATE_BLOCKED);
    point.set_use(v1::LinkPoint::USE_SUSPENDED);
    point.add_anchors()->set_map("sites/s/maps/h");
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"linkpoint", "list", "--map", "Hall", "--candidates"}, false));
  EXPECT_EQ(asked.map(), "sites/s/maps/h");
  EXPECT_EQ(asked.subset(), v1::LINK_POINT_SUBSET_CANDIDATES);
  EXPECT_THAT(printed_, HasSubstr("h (candidate)"));
  EXPECT_THAT(printed_, HasSubstr("blocked  suspended"));
}

TEST_F(LinkPointCommandsTest, NearAsksAroundAPoseOrAPoint) {
  v1::FindLinkPointsRequest asked;
  server_.link_points.find = [&](const v1::FindLinkPointsRequest& request, v1::FindLinkPointsResponse& response) {
    asked = request;
    response.set_radius_m(20.0);
    response.set_graph_version(5);
    response.add_found()->set_distance_m(1.25);
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"linkpoint", "near", "--at", "Hall,1,2,0.5", "--radius", "30", "--nearest", "3"}));
  EXPECT_EQ(asked.pose_in_map().map(), "sites/s/maps/h");
  EXPECT_EQ(asked.base_radius_m(), 30.0);
  EXPECT_FALSE(asked.has_radius_m());
  EXPECT_EQ(asked.max_count(), 3);
  EXPECT_EQ(Printed()["found"][0]["distance_m"], 1.25);
  ASSERT_OK(Run({"linkpoint", "near", "--world", "-1", "2"}, false));
  EXPECT_EQ(asked.point_world().x(), -1.0);
  EXPECT_FALSE(asked.has_radius_m()) << "no limit";
  EXPECT_THAT(printed_, HasSubstr("within 20.00 m, graph version 5"));
}

TEST_F(LinkPointCommandsTest, AStateMayEndByItself) {
  v1::UpdateLinkPointRequest asked;
  server_.link_points.update = [&](const v1::UpdateLinkPointRequest& request, v1::UpdateLinkPointResponse& response) {
    asked = request;
    *response.mutable_link_point() = request.link_point();
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"linkpoint", "state", "door", "blocked", "--for", "3600"}));
  EXPECT_EQ(asked.link_point().state(), v1::LinkPoint::STATE_BLOCKED);
  const std::int64_t now = std::time(nullptr);
  EXPECT_NEAR(static_cast<double>(asked.link_point().state_valid_until().seconds() - now), 3600.0, 60.0);
  ASSERT_OK(Run({"linkpoint", "state", "door", "open"}));
  EXPECT_FALSE(asked.link_point().has_state_valid_until());
  EXPECT_THAT(std::vector<std::string>(asked.update_mask().paths().begin(), asked.update_mask().paths().end()),
              ElementsAre("state", "state_valid_until"))
      << "an earlier end is cleared, too";
}

TEST_F(LinkPointCommandsTest, SuspendResumeAndDeleteNameIt) {
  std::vector<std::string> names;
  const auto answer = [&](const auto& request, auto& response) {
    names.push_back(request.name());
    response.mutable_link_point()->set_name(request.name());
    return grpc::Status::OK;
  };
  server_.link_points.suspend = answer;
  server_.link_points.resume = answer;
  server_.link_points.remove = [&](const v1::DeleteLinkPointRequest& request, v1::DeleteLinkPointResponse&) {
    names.push_back(request.name());
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"linkpoint", "suspend", "a"}, false));
  EXPECT_THAT(printed_, HasSubstr("sites/s/linkPoints/a is suspended"));
  ASSERT_OK(Run({"linkpoint", "resume", "sites/t/linkPoints/b"}));
  ASSERT_OK(Run({"linkpoint", "delete", "c"}));
  EXPECT_EQ(Printed()["deleted"], "sites/s/linkPoints/c");
  EXPECT_THAT(names, ElementsAre("sites/s/linkPoints/a", "sites/t/linkPoints/b", "sites/s/linkPoints/c"));
}

}  // namespace
}  // namespace enfilade::cli
