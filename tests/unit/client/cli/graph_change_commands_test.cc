// SPDX-License-Identifier: Apache-2.0
// Commands that change the graph: linkpoint move and undo, graph change, map align.
#include <cmath>
#include <fstream>

#include "tests/unit/client/cli/server_commands_fixture.h"

namespace enfilade::cli {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class GraphChangeCommandsTest : public ServerCommandsTest {
 protected:
  GraphChangeCommandsTest() {
    server_.link_points.get = [](const v1::GetLinkPointRequest& request, v1::GetLinkPointResponse& response) {
      v1::LinkPoint& link_point = *response.mutable_link_point();
      link_point.set_name(request.name());
      link_point.set_etag("41");
      link_point.set_tag("north");
      link_point.set_use(v1::LinkPoint::USE_USED);
      for (const char* map : {"h", "l"}) {
        v1::Anchor& anchor = *link_point.add_anchors();
        anchor.set_map("sites/s/maps/" + std::string(map));
        anchor.mutable_pose_map_place()->mutable_pose()->set_x(1.5);
        for (int i = 0; i < 9; ++i) anchor.mutable_pose_map_place()->add_covariance(i % 4 == 0 ? 0.25 : 0.0);
      }
      return grpc::Status::OK;
    };
    server_.graph.change = [this](const v1::ChangeGraphRequest& request, v1::ChangeGraphResponse& response) {
      changed_ = request;
      response.set_graph_version(12);
      for (const v1::GraphChange& change : request.changes()) {
        if (change.has_updated()) *response.add_link_points() = change.updated();
      }
      return grpc::Status::OK;
    };
    server_.graph.preview = [this](const v1::PreviewGraphRequest& request, v1::PreviewGraphResponse& response) {
      previewed_ = request;
      response.set_graph_version(11);
      response.set_chi2_after(31.5);
      v1::MovedMap& moved = *response.add_moved_maps();
      moved.set_map("sites/s/maps/l");
      moved.mutable_pose_world_map_before()->mutable_pose()->set_x(8.0);
      moved.mutable_pose_world_map_after()->mutable_pose()->set_x(8.25);
      response.add_moved_maps()->set_map("sites/s/maps/x");
      response.mutable_moved_maps(1)->mutable_pose_world_map_after();
      v1::LinkPointResidual& residual = *response.add_residuals();
      residual.set_link_point("sites/s/linkPoints/door");
      residual.set_chi2_after(40.0);
      residual.set_gate(16.27);
      residual.set_switched_off_after(true);
      response.add_disconnected_maps("sites/s/maps/far");
      return grpc::Status::OK;
    };
  }

  v1::ChangeGraphRequest changed_;
  v1::PreviewGraphRequest previewed_;
};

TEST_F(GraphChangeCommandsTest, MoveWritesOneAnchorWithItsCovarianceUnderTheEtag) {
  ASSERT_OK(Run({"linkpoint", "move", "door", "--map", "Lab", "--pose", "-2,3,0.5", "--sigma", "0.02,1"}));
  ASSERT_EQ(changed_.changes_size(), 1);
  const v1::GraphChange& change = changed_.changes(0);
  EXPECT_EQ(changed_.site(), "sites/s");
  EXPECT_THAT(change.update_mask().paths(), ElementsAre("anchors"));
  EXPECT_EQ(change.updated().name(), "sites/s/linkPoints/door");
  EXPECT_EQ(change.updated().etag(), "41");
  ASSERT_EQ(change.updated().anchors_size(), 2);
  EXPECT_EQ(change.updated().anchors(0).pose_map_place().pose().x(), 1.5);
  const v1::PoseWithCovariance& moved = change.updated().anchors(1).pose_map_place();
  EXPECT_EQ(moved.pose().x(), -2.0);
  EXPECT_EQ(moved.pose().yaw(), 0.5);
  EXPECT_NEAR(moved.covariance(4), 0.0004, 1e-12);
  EXPECT_NEAR(moved.covariance(8), std::pow(M_PI / 180.0, 2), 1e-12);
  EXPECT_EQ(moved.covariance(1), 0.0);
  EXPECT_EQ(Printed()["graph_version"], 12);
  EXPECT_EQ(Printed()["link_points"][0]["name"], "sites/s/linkPoints/door");
}

TEST_F(GraphChangeCommandsTest, APreviewShowsWhatMovesAndChangesNothing) {
  ASSERT_OK(Run({"linkpoint", "move", "door", "--map", "Hall", "--pose", "1,2,0", "--preview"}, false));
  EXPECT_EQ(changed_.changes_size(), 0);
  ASSERT_EQ(previewed_.changes_size(), 1);
  EXPECT_NEAR(previewed_.changes(0).updated().anchors(0).pose_map_place().covariance(0), 0.01, 1e-12);
  EXPECT_THAT(printed_, AllOf(HasSubstr("l    0.250 m, 0.00 deg"), HasSubstr("x    joined to the root")));
  EXPECT_THAT(printed_, AllOf(HasSubstr("switched off"), HasSubstr("16.3"), HasSubstr("nothing was changed")));
  EXPECT_THAT(printed_, HasSubstr("not joined to the root: far"));
  ASSERT_OK(Run({"linkpoint", "move", "door", "--map", "Hall", "--pose", "1,2,0", "--preview"}));
  EXPECT_EQ(Printed()["residuals"][0]["switched_off_after"], true);
  EXPECT_EQ(Printed()["moved_maps"][0]["pose_world_map_after"]["x"], 8.25);
  EXPECT_FALSE(Printed()["moved_maps"][1].contains("pose_world_map_before"));
}

TEST_F(GraphChangeCommandsTest, MoveRefusesWhatIsNoPoseOrNoAnchor) {
  const auto status = [&](const std::string& pose, const std::string& sigma) {
    return Run({"linkpoint", "move", "door", "--map", "Hall", "--pose", pose, "--sigma", sigma});
  };
  EXPECT_STATUS(status("1,2", "0.1,2"), absl::StatusCode::kInvalidArgument, HasSubstr("--pose is \"1,2\""));
  EXPECT_STATUS(status("1,2,nan", "0.1,2"), absl::StatusCode::kInvalidArgument, HasSubstr("X,Y,YAW"));
  EXPECT_STATUS(status("1,2,0", "0,2"), absl::StatusCode::kInvalidArgument, HasSubstr("METRES,DEGREES"));
  server_.link_points.get = [](const v1::GetLinkPointRequest& request, v1::GetLinkPointResponse& response) {
    response.mutable_link_point()->set_name(request.name());
    return grpc::Status::OK;
  };
  EXPECT_STATUS(status("1,2,0", "0.1,2"), absl::StatusCode::kInvalidArgument, HasSubstr("no anchor in sites/s/maps/h"));
  EXPECT_EQ(changed_.changes_size(), 0);
}

TEST_F(GraphChangeCommandsTest, UndoSendsTheInverseOfAllThatWasChangedTogether) {
  server_.sites.list_audit_entries = [](const v1::ListAuditEntriesRequest&, v1::ListAuditEntriesResponse& response) {
    const auto add = [&](const std::string& id, std::int64_t time, const std::string& resource) -> v1::AuditEntry& {
      v1::AuditEntry& entry = *response.add_entries();
      entry.set_id(id);
      entry.set_actor("bob");
      entry.mutable_time()->set_seconds(time);
      entry.set_resource("sites/s/" + resource);
      entry.set_action(v1::AuditEntry::ACTION_UPDATED);
      return entry;
    };
    const std::string row =
        R"({"site_id":"s","link_point_id":"door","kind":1,"difficulty":0,"environment":0,"state":1,)";
    const std::string anchor = R"({"site_id":"s","link_point_id":"door","map_id":"h","ordinal":1,"y":0,"yaw":0,)"
                               R"("covariance":[0.25,0,0,0,0.25,0,0,0,0.25],)";
    v1::AuditEntry& damaged = add("9", 200, "linkPoints/door");
    damaged.set_before("no JSON");
    damaged.set_after("no JSON");
    v1::AuditEntry& moved = add("8", 100, "linkPoints/door/anchors/h");
    moved.set_before(anchor + R"("x":7.25})");
    moved.set_after(anchor + R"("x":1.5})");
    v1::AuditEntry& tagged = add("7", 100, "linkPoints/door");
    tagged.set_before(row + R"("tag":"south","use":1})");
    tagged.set_after(row + R"("tag":"north","use":1})");
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"linkpoint", "undo", "7"}));
  ASSERT_EQ(changed_.changes_size(), 1);
  const v1::GraphChange& change = changed_.changes(0);
  EXPECT_THAT(change.update_mask().paths(), ElementsAre("tag", "anchors"));
  EXPECT_EQ(change.updated().tag(), "south");
  EXPECT_EQ(change.updated().etag(), "41");
  EXPECT_EQ(change.updated().anchors(0).pose_map_place().pose().x(), 7.25);
  EXPECT_EQ(change.updated().anchors(1).pose_map_place().pose().x(), 1.5);
  EXPECT_STATUS(Run({"linkpoint", "undo", "3"}), absl::StatusCode::kNotFound, HasSubstr("audit entry 3"));
  EXPECT_CODE(Run({"linkpoint", "undo", "9"}), absl::StatusCode::kDataLoss);
}

TEST_F(GraphChangeCommandsTest, ChangesComeFromAFileAsInTheApi) {
  const std::string path = (directory_.path() / "changes.json").string();
  const auto write = [&](const std::string& text) { std::ofstream(path) << text; };
  write(R"({"changes": [{"suspended": "sites/s/linkPoints/door", "etag": "4"},
                        {"updated": {"name": "sites/s/linkPoints/gate", "tag": "t"}, "updateMask": "tag"}]})");
  ASSERT_OK(Run({"graph", "change", path}, false));
  ASSERT_EQ(changed_.changes_size(), 2);
  EXPECT_EQ(changed_.changes(0).suspended(), "sites/s/linkPoints/door");
  EXPECT_THAT(changed_.changes(1).update_mask().paths(), ElementsAre("tag"));
  EXPECT_THAT(printed_, HasSubstr("graph version 12"));
  ASSERT_OK(Run({"graph", "change", path, "--preview"}));
  EXPECT_EQ(previewed_.changes_size(), 2);
  write("{\"changes\": [{\"moved\": 1}]}");
  EXPECT_STATUS(Run({"graph", "change", path}), absl::StatusCode::kInvalidArgument,
                AllOf(HasSubstr("changes.json"), HasSubstr("moved")));
  write("{\"site\": \"sites/other\"}");
  EXPECT_STATUS(Run({"graph", "change", path}), absl::StatusCode::kInvalidArgument, HasSubstr("--site"));
  EXPECT_CODE(Run({"graph", "change", path + ".none"}), absl::StatusCode::kNotFound);
}

TEST_F(GraphChangeCommandsTest, AlignAsksAroundTheGuessAndSaysWhyNot) {
  v1::AlignMapsRequest asked;
  server_.graph.align = [&](const v1::AlignMapsRequest& request, v1::AlignMapsResponse& response) {
    asked = request;
    response.set_reason("ambiguous: they fit nearly as well 4.0 m farther");
    if (!request.has_pose_a_b()) return grpc::Status::OK;
    response.set_accepted(true);
    response.set_reason("40 m of wall match, 1.0 m do not");
    response.mutable_pose_a_b()->mutable_pose()->set_x(12.5);
    for (int i = 0; i < 9; ++i) response.mutable_pose_a_b()->add_covariance(i % 4 == 0 ? 0.0004 : 0.0);
    response.set_score(0.93);
    response.set_rival_ratio(4.0);
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"map", "align", "Hall", "Lab", "--guess", "12,0,1.5", "--radius", "3", "--yaw-range", "90"}, false));
  EXPECT_EQ(asked.map_a(), "sites/s/maps/h");
  EXPECT_EQ(asked.map_b(), "sites/s/maps/l");
  EXPECT_EQ(asked.pose_a_b().yaw(), 1.5);
  EXPECT_EQ(asked.radius_m(), 3.0);
  EXPECT_NEAR(asked.yaw_range_rad(), M_PI / 2.0, 1e-12);
  EXPECT_THAT(printed_, AllOf(HasSubstr("fits: 40 m"), HasSubstr("12.500,0.000,0.0000"), HasSubstr("0.020 m"),
                              HasSubstr("4.0 times")));
  ASSERT_OK(Run({"map", "align", "Hall", "Lab"}, false));
  EXPECT_FALSE(asked.has_pose_a_b());
  EXPECT_THAT(printed_, HasSubstr("not certain: ambiguous"));
  ASSERT_OK(Run({"map", "align", "Hall", "Lab"}));
  EXPECT_EQ(Printed()["accepted"], false);
  EXPECT_FALSE(Printed().contains("pose_a_b"));
  EXPECT_STATUS(Run({"map", "align", "Hall", "Lab", "--guess", "1,2"}), absl::StatusCode::kInvalidArgument,
                HasSubstr("--guess is \"1,2\""));
}

}  // namespace
}  // namespace enfilade::cli
