// SPDX-License-Identifier: Apache-2.0
// Commands for sessions, sites and the server: what they ask for, and what they print.
#include "tests/unit/client/cli/server_commands_fixture.h"

namespace enfilade::cli {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST_F(ServerCommandsTest, SessionsAreListedOverAllPages) {
  server_.sessions.list = [](const v1::ListSessionsRequest& request, v1::ListSessionsResponse& response) {
    const bool first = request.page_token().empty();
    v1::Session& session = *response.add_sessions();
    session.set_name(first ? "sites/s/sessions/a" : "sites/s/sessions/b");
    session.set_robot("sites/s/robots/r1");
    session.set_state(first ? v1::Session::STATE_MAPPED : v1::Session::STATE_RECORDING);
    session.set_acknowledged_sequence(12);
    if (first) response.set_next_page_token("2");
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"session", "list"}, false));
  EXPECT_THAT(printed_, HasSubstr("a        r1     -    MAPPED     12       0"));
  EXPECT_THAT(printed_, HasSubstr("b        r1     -    RECORDING  12       0"));
  ASSERT_OK(Run({"session", "list"}));
  EXPECT_EQ(Printed().size(), 2U);
}

TEST_F(ServerCommandsTest, ASessionsIdAndItsResourceNameMeanTheSame) {
  std::vector<std::string> asked;
  server_.sessions.get = [&](const v1::GetSessionRequest& request, v1::GetSessionResponse& response) {
    asked.push_back(request.name());
    response.mutable_session()->set_error("lost");
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"session", "show", "run"}));
  ASSERT_OK(Run({"session", "show", "sites/other/sessions/run"}, false));
  EXPECT_THAT(asked, ElementsAre("sites/s/sessions/run", "sites/other/sessions/run"));
  EXPECT_THAT(printed_, HasSubstr("(only recorded)"));
  EXPECT_THAT(printed_, HasSubstr("error    lost"));
}

TEST_F(ServerCommandsTest, RejectedLoopClosuresAreListedOnRequest) {
  server_.sessions.list_closures = [](const v1::ListClosuresRequest& request, v1::ListClosuresResponse& response) {
    EXPECT_EQ(request.parent(), "sites/s/sessions/run");
    for (const auto state : {v1::Closure::STATE_ACCEPTED, v1::Closure::STATE_REJECTED, v1::Closure::STATE_SUSPENDED}) {
      v1::Closure& closure = *response.add_closures();
      closure.set_name("sites/s/sessions/run/closures/" + std::to_string(response.closures_size()));
      closure.set_state(state);
      closure.set_score(0.625);
    }
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"closure", "list", "run"}));
  ASSERT_EQ(Printed().size(), 2U);
  EXPECT_EQ(Printed()[1]["state"], "suspended");
  ASSERT_OK(Run({"closure", "list", "run", "--all"}, false));
  EXPECT_THAT(printed_, HasSubstr("2        rejected   0       0     0.62"));
}

TEST_F(ServerCommandsTest, SuspendingAndResumingNameTheClosure) {
  std::vector<std::string> names;
  const auto answer = [&](const auto& request, auto& response) {
    names.push_back(request.name());
    response.mutable_closure()->set_name(request.name());
    response.mutable_closure()->set_state(v1::Closure::STATE_SUSPENDED);
    return grpc::Status::OK;
  };
  server_.sessions.suspend_closure = answer;
  server_.sessions.resume_closure = answer;
  ASSERT_OK(Run({"closure", "suspend", "run", "5"}, false));
  EXPECT_THAT(printed_, HasSubstr("sites/s/sessions/run/closures/5 is suspended"));
  ASSERT_OK(Run({"closure", "resume", "run", "7"}));
  EXPECT_EQ(Printed()["state"], "suspended");
  EXPECT_THAT(names, ElementsAre("sites/s/sessions/run/closures/5", "sites/s/sessions/run/closures/7"));
}

TEST_F(ServerCommandsTest, DoorVerdictsComeWithTheirComparisons) {
  server_.sessions.list_door_verdicts = [](const v1::ListDoorVerdictsRequest&, v1::ListDoorVerdictsResponse& response) {
    v1::DoorVerdict& verdict = *response.add_verdicts();
    verdict.set_name("sites/s/sessions/run/doorVerdicts/9");
    verdict.set_decision(v1::DoorVerdict::DECISION_LINK_POINT_RECOGNISED);
    verdict.set_link_point("sites/s/linkPoints/door");
    verdict.add_comparisons()->set_image_matches(31);
    verdict.set_reason("31 matches");
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"session", "doors", "run"}));
  EXPECT_EQ(Printed()[0]["decision"], "link point recognised");
  EXPECT_EQ(Printed()[0]["comparisons"][0]["image_matches"], 31);
  EXPECT_TRUE(Printed()[0]["pose_map_robot"].is_null());
  ASSERT_OK(Run({"session", "doors", "run"}, false));
  EXPECT_THAT(printed_, HasSubstr("9       link point recognised  door        -            1         31 matches"));
}

TEST_F(ServerCommandsTest, ATrajectoryIsWrittenWithNanoseconds) {
  server_.sessions.export_trajectory = [](const auto&, grpc::ServerWriter<v1::ExportTrajectoryResponse>& writer) {
    v1::ExportTrajectoryResponse part;
    v1::TrajectoryPose& pose = *part.add_poses();
    pose.mutable_time()->set_seconds(17);
    pose.mutable_time()->set_nanos(5);
    pose.mutable_pose_map_robot()->set_x(1.5);
    writer.Write(part);
    return grpc::Status::OK;
  };
  const std::string file = directory_.path() / "t.txt";
  ASSERT_OK(Run({"trajectory", "export", "run", "-o", file}));
  EXPECT_EQ(Content(file), "17.000000005 1.5 0 0\n");
  EXPECT_EQ(Printed()["poses"], 1);
  ASSERT_OK(Run({"trajectory", "export", "run", "-o", "-"}));
  EXPECT_EQ(printed_, "17.000000005 1.5 0 0\n") << "nothing but the trajectory";
  EXPECT_CODE(Run({"trajectory", "export", "run", "-o", "/none/t.txt"}), absl::StatusCode::kInvalidArgument);
}

// The robot drove 1 s in the hall and 1 s in the lab, which has no place in the world; session 0 is another robot's.
class RobotTrajectoryTest : public ServerCommandsTest {
 protected:
  RobotTrajectoryTest() {
    server_.graph.get_graph = [this](const v1::GetGraphRequest&, v1::GetGraphResponse& response) {
      v1::Graph& graph = *response.mutable_graph();
      graph.set_site("sites/s");
      graph.set_graph_version(++reads_ <= changes_ ? reads_ : changes_ + 1);
      v1::GraphMap& hall = *graph.add_maps();
      hall.set_map("sites/s/maps/h");
      hall.set_display_name("Hall");
      hall.mutable_pose_world_map()->mutable_pose()->set_x(10.0);
      v1::GraphMap& lab = *graph.add_maps();
      lab.set_map("sites/s/maps/l");
      lab.set_display_name("Lab");
      if (lab_is_placed_) lab.mutable_pose_world_map()->mutable_pose()->set_y(3.0);
      return grpc::Status::OK;
    };
    server_.sessions.list = [](const v1::ListSessionsRequest&, v1::ListSessionsResponse& response) {
      for (const int i : {2, 1, 0}) {
        v1::Session& session = *response.add_sessions();
        session.set_name("sites/s/sessions/" + std::to_string(i));
        session.set_robot(i == 0 ? "sites/s/robots/r9" : "sites/s/robots/r1");
        session.set_map(i == 1 ? "sites/s/maps/h" : "sites/s/maps/l");
      }
      return grpc::Status::OK;
    };
    server_.sessions.export_trajectory = [](const v1::ExportTrajectoryRequest& request,
                                            grpc::ServerWriter<v1::ExportTrajectoryResponse>& writer) {
      v1::ExportTrajectoryResponse part;
      v1::TrajectoryPose& pose = *part.add_poses();
      pose.mutable_time()->set_seconds(request.name().back() - '0');
      pose.mutable_pose_map_robot()->set_x(1.5);
      writer.Write(part);
      return grpc::Status::OK;
    };
  }

  int reads_ = 0;
  int changes_ = 0;  // how many of the first reads see another version than the one before
  bool lab_is_placed_ = true;
};

TEST_F(RobotTrajectoryTest, HoldsAllSessionsInTheWorld) {
  ASSERT_OK(Run({"trajectory", "export", "--robot", "r1", "--world", "-o", "-"}));
  EXPECT_EQ(printed_, "1.000000000 11.5 0 0\n2.000000000 1.5 3 0\n");
}

TEST_F(RobotTrajectoryTest, NamesTheMapsThatAreLeftOut) {
  lab_is_placed_ = false;
  const std::string file = directory_.path() / "t.txt";
  EXPECT_STATUS(Run({"trajectory", "export", "--robot", "r1", "--world", "-o", file}),
                absl::StatusCode::kFailedPrecondition, HasSubstr("1 poses are left out"));
  EXPECT_EQ(Content(file), "1.000000000 11.5 0 0\n") << "the others are written";
  EXPECT_EQ(Printed()["left_out"], nlohmann::json({"map \"Lab\""}));
  EXPECT_EQ(Printed()["sessions"], 2);
}

TEST_F(RobotTrajectoryTest, IsReadAtOneVersionOfTheGraph) {
  changes_ = 3;
  ASSERT_OK(Run({"trajectory", "export", "--robot", "r1", "--world", "-o", "-"}));
  EXPECT_EQ(reads_, 5) << "until two reads are equal";
  reads_ = 0;
  changes_ = 100;
  EXPECT_CODE(Run({"trajectory", "export", "--robot", "r1", "--world", "-o", "-"}), absl::StatusCode::kAborted);
}

TEST_F(RobotTrajectoryTest, NeedsARobotWithSessionsAndTheWorld) {
  EXPECT_CODE(Run({"trajectory", "export", "--robot", "r3", "--world", "-o", "-"}), absl::StatusCode::kNotFound);
  EXPECT_CODE(Run({"trajectory", "export", "--robot", "r1", "-o", "-"}), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(Run({"trajectory", "export", "1", "--world", "-o", "-"}), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(Run({"trajectory", "export", "1", "--robot", "r1", "--world", "-o", "-"}),
              absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(Run({"trajectory", "export", "-o", "-"}), absl::StatusCode::kInvalidArgument);
}

TEST_F(ServerCommandsTest, SitesAreCreatedAndListed) {
  v1::CreateSiteRequest created;
  server_.sites.create = [&](const v1::CreateSiteRequest& request, v1::CreateSiteResponse& response) {
    created = request;
    *response.mutable_site() = request.site();
    response.mutable_site()->set_name("sites/" + request.site_id());
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"site", "create", "north", "--retention-days", "2"}));
  EXPECT_EQ(created.site().display_name(), "north") << "its id, without a name";
  EXPECT_EQ(created.site().raw_retention().seconds(), 172'800);
  EXPECT_EQ(Printed()["raw_retention_s"], 172'800);
  server_.sites.list = [](const v1::ListSitesRequest&, v1::ListSitesResponse& response) {
    response.add_sites()->set_name("sites/a");
    response.add_sites()->set_name("sites/b");
    response.mutable_sites(1)->mutable_raw_retention()->set_seconds(3600);
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"site", "list"}, false));
  EXPECT_THAT(printed_, HasSubstr("a           forever"));
  EXPECT_THAT(printed_, HasSubstr("b           1:00:00"));
}

TEST_F(ServerCommandsTest, ASiteKeepsWhatItIsToldTo) {
  v1::UpdateSiteRequest updated;
  server_.sites.update = [&](const v1::UpdateSiteRequest& request, v1::UpdateSiteResponse& response) {
    updated = request;
    *response.mutable_site() = request.site();
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"site", "update", "north", "--revisions", "20", "--revision-days", "7", "--history-days", "-1"}));
  EXPECT_EQ(updated.site().name(), "sites/north");
  EXPECT_THAT(updated.update_mask().paths(), ::testing::ElementsAre("revision_retention", "history_retention"));
  EXPECT_EQ(updated.site().revision_retention().newest(), 20);
  EXPECT_EQ(updated.site().revision_retention().age().seconds(), 604'800);
  EXPECT_FALSE(updated.site().has_history_retention()) << "-1: for ever";
  EXPECT_EQ(Printed()["revisions_kept"], 20);
  EXPECT_CODE(Run({"site", "update", "north"}), absl::StatusCode::kInvalidArgument);
}

TEST_F(ServerCommandsTest, TheAuditTrailLeavesTheSiteOut) {
  v1::ListAuditEntriesRequest asked;
  server_.sites.list_audit_entries = [&](const v1::ListAuditEntriesRequest& request,
                                         v1::ListAuditEntriesResponse& response) {
    asked = request;
    v1::AuditEntry& entry = *response.add_entries();
    entry.set_action(v1::AuditEntry::ACTION_DELETED);
    entry.set_resource("sites/s/linkPoints/door");
    entry.set_before("{\"tag\":\"x\"}");
    entry.set_after("not JSON");
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"site", "audit", "linkPoints/door", "-n", "7"}, false));
  EXPECT_EQ(asked.resource(), "sites/s/linkPoints/door");
  EXPECT_EQ(asked.page_size(), 7);
  EXPECT_THAT(printed_, HasSubstr("-    deleted  linkPoints/door"));
  ASSERT_OK(Run({"site", "audit"}));
  EXPECT_EQ(Printed()[0]["before"]["tag"], "x");
  EXPECT_EQ(Printed()[0]["after"], "not JSON") << "and the document stays valid";
  EXPECT_EQ(asked.resource(), "");
}

TEST_F(ServerCommandsTest, AServerThatIsNotReadyIsAnError) {
  bool ready = true;
  server_.status.get = [&](const v1::GetServerStatusRequest&, v1::GetServerStatusResponse& response) {
    response.set_version("1.2");
    response.set_ready(ready);
    response.set_not_ready_reason(ready ? "" : "no database");
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"server", "status"}));
  EXPECT_EQ(Printed()["version"], "1.2");
  ready = false;
  EXPECT_CODE(Run({"server", "status"}, false), absl::StatusCode::kUnavailable);
  EXPECT_THAT(printed_, HasSubstr("NOT READY: no database"));
}

}  // namespace
}  // namespace enfilade::cli
