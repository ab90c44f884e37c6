// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "tests/unit/client/cli/server_commands_fixture.h"

namespace enfilade::cli {
namespace {

using ::testing::HasSubstr;

class RearrangeCommandsTest : public ServerCommandsTest {
 protected:
  static void Fill(v1::Rearrangement& rearrangement) {
    rearrangement.set_name("sites/s/rearrangements/x1");
    rearrangement.set_reason("one room");
    rearrangement.set_graph_version(7);
    rearrangement.mutable_create_time()->set_seconds(1'700'000'000);
    v1::MergedMap& merged = *rearrangement.add_merged_maps();
    merged.set_map("sites/s/maps/l");
    merged.set_into("sites/s/maps/h");
    rearrangement.add_moved_sessions()->set_session("sites/s/sessions/s1");
  }
};

TEST_F(RearrangeCommandsTest, MapsAreMergedByTheGraphOrByAPose) {
  v1::MergeMapsRequest asked;
  server_.maps.merge_maps = [&](const v1::MergeMapsRequest& request, v1::MergeMapsResponse& response) {
    asked = request;
    Fill(*response.mutable_rearrangement());
    response.mutable_map()->set_display_name("Hall");
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"map", "merge", "Hall", "Lab"}));
  EXPECT_EQ(asked.name(), "sites/s/maps/h");
  EXPECT_EQ(asked.merged_map(), "sites/s/maps/l");
  EXPECT_FALSE(asked.has_pose_name_merged());
  EXPECT_EQ(Printed()["merged_maps"][0]["into"], "sites/s/maps/h");
  ASSERT_OK(Run({"map", "merge", "Hall", "Lab", "--pose", "3", "-2", "90"}, false));
  EXPECT_EQ(asked.pose_name_merged().y(), -2.0);
  EXPECT_NEAR(asked.pose_name_merged().yaw(), M_PI / 2, 1e-12);
  EXPECT_EQ(printed_,
            "merged into \"Hall\": one room\n"
            "1 sessions moved, 0 link points changed, 0 removed; sites/s/rearrangements/x1\n");
}

TEST_F(RearrangeCommandsTest, SessionsAndTheirRestsLeaveAMap) {
  v1::SplitMapRequest asked;
  server_.maps.split_map = [&](const v1::SplitMapRequest& request, v1::SplitMapResponse& response) {
    asked = request;
    Fill(*response.mutable_rearrangement());
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"map", "split", "Hall", "s1", "sites/s/sessions/s2@120", "--id", "annex"}));
  EXPECT_EQ(asked.name(), "sites/s/maps/h");
  EXPECT_EQ(asked.map_id(), "annex");
  ASSERT_EQ(asked.sessions_size(), 1);
  EXPECT_EQ(asked.sessions(0), "sites/s/sessions/s1");
  ASSERT_EQ(asked.cuts_size(), 1);
  EXPECT_EQ(asked.cuts(0).session(), "sites/s/sessions/s2");
  EXPECT_EQ(asked.cuts(0).first_sequence(), 120);
  for (const std::string wrong : {"s1@", "s1@x", "s1@12x"}) {
    EXPECT_STATUS(Run({"map", "split", "Hall", wrong}), absl::StatusCode::kInvalidArgument, HasSubstr(wrong));
  }
}

TEST_F(RearrangeCommandsTest, ARearrangementIsListedAndUndone) {
  server_.maps.list_rearrangements = [](const v1::ListRearrangementsRequest& request,
                                        v1::ListRearrangementsResponse& response) {
    EXPECT_EQ(request.parent(), "sites/s");
    Fill(*response.add_rearrangements());
    Fill(*response.add_rearrangements());
    response.mutable_rearrangements(1)->set_undo_expired(true);
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"map", "rearrangements"}, false));
  EXPECT_THAT(printed_, HasSubstr("in effect"));
  EXPECT_THAT(printed_, HasSubstr("permanent"));
  EXPECT_THAT(printed_, HasSubstr("one room"));
  server_.maps.undo_rearrangement = [](const v1::UndoRearrangementRequest& request,
                                       v1::UndoRearrangementResponse& response) {
    EXPECT_EQ(request.name(), "sites/s/rearrangements/x1");
    Fill(*response.mutable_rearrangement());
    response.mutable_rearrangement()->set_undo_graph_version(8);
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"map", "undo", "x1"}));
  EXPECT_EQ(Printed()["undone"], true);
}

}  // namespace
}  // namespace enfilade::cli
