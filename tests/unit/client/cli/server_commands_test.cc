// SPDX-License-Identifier: Apache-2.0
// Commands that call a server: what they ask for, and what they print of its answers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/remote.h"
#include "core/base/sha256.h"
#include "io/file.h"
#include "tests/support/scripted_server.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/client/cli/command_test.h"

namespace enfilade::cli {
namespace {

using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

class ServerCommandsTest : public CommandTest {
 protected:
  ServerCommandsTest() {
    globals_.server = server_.address();
    globals_.site = "s";
    globals_.actor = "ann";
    globals_.timeout_s = 20.0;
    // The maps Hall and Lab.
    server_.maps.list_maps = [](const v1::ListMapsRequest& request, v1::ListMapsResponse& response) {
      for (const std::string name : {"Hall", "Lab"}) {
        if (!request.display_name().empty() && request.display_name() != name) continue;
        v1::Map& map = *response.add_maps();
        map.set_name("sites/s/maps/" + std::string(name == "Hall" ? "h" : "l"));
        map.set_display_name(name);
        map.set_level(name == "Hall" ? 0 : 1);
        map.set_environment(name == "Hall" ? v1::Map::ENVIRONMENT_INDOOR : v1::Map::ENVIRONMENT_OUTDOOR);
        map.set_etag("e-" + name);
        if (name == "Lab") map.set_latest_revision("sites/s/maps/l/revisions/4");
      }
      return grpc::Status::OK;
    };
    server_.maps.get_map = [](const v1::GetMapRequest&, v1::GetMapResponse&) {
      return grpc::Status(grpc::StatusCode::NOT_FOUND, "no map");
    };
  }

  absl::Status Run(std::vector<std::string> arguments, bool as_json = true) {
    const auto add = [](CLI::App& app, const Globals& globals) {
      AddGraph(app, globals);
      AddImport(app, globals);
      AddLinkPoint(app, globals);
      AddLoopClosure(app, globals);
      AddMap(app, globals);
      AddPose(app, globals);
      AddReplay(app, globals);
      AddServer(app, globals);
      AddSession(app, globals);
      AddSite(app, globals);
      AddTrajectory(app, globals);
      AddCompletion(app);
    };
    return RunCommandLine(add, std::move(arguments), as_json);
  }
  json Printed() const { return json::parse(printed_, nullptr, false); }

  enfilade::testing::ScriptedServer server_{(directory_.path() / "s").string()};
};

TEST_F(ServerCommandsTest, EveryCommandRefusesBadArgumentsBeforeItCalls) {
  const std::vector<std::vector<std::string>> cases = {
      {"map", "export"},
      {"map", "export", "Hall", "--format", "tiff"},
      {"map", "import", "a.yaml"},
      {"map", "import", "a.yaml", "--map", "Hall", "--dialect", "ros3"},
      {"map", "create"},
      {"map", "create", "A", "--environment", "moon"},
      {"map", "create", "A", "--outline", "0", "0", "1"},
      {"map", "create", "A", "--outline", "0", "0", "1", "0", "1", "1", "0"},
      {"map", "show"},
      {"map", "delete"},
      {"map"},
      {"linkpoint", "set"},
      {"linkpoint", "set", "--at", "Hall,1,2"},
      {"linkpoint", "set", "--at", "Hall", "--at", "Lab,0,0"},
      {"linkpoint", "set", "--at", "Hall,1,2", "--at", "Lab,0,0", "--kind", "window"},
      {"linkpoint", "candidate", "--at", "Hall,1,2", "--at", "Lab,0,0"},
      {"linkpoint", "near"},
      {"linkpoint", "near", "--world", "1"},
      {"linkpoint", "near", "--at", "Hall"},
      {"linkpoint", "state", "d"},
      {"linkpoint", "state", "d", "ajar"},
      {"linkpoint", "suspend"},
      {"graph", "plot", "-o", "graph.jpg"},
      {"graph", "versions", "--count", "0"},
      {"graph", "show", "--version", "old"},
      {"pose", "global"},
      {"pose", "global", "--at", "Hall,1"},
      {"route", "Hall,1,2"},
      {"route", "Hall,1,2", "Lab"},
      {"route", "Hall,1,2", "Lab,1,2", "--cost", "fun"},
      {"closure", "list"},
      {"closure", "suspend", "run"},
      {"closure", "suspend", "run", "first"},
      {"session", "show"},
      {"session", "doors"},
      {"site", "create"},
      {"site", "audit", "-n", "0"},
      {"site", "audit", "-n", "1001"},
      {"trajectory", "export", "run"},
      {"import", "mapmanager"},
      {"import", "building"},
      {"replay", "a.log"},
      {"replay", "a.log", "--map", "m", "--record-only"},
      {"replay", "a.log", "--record-only", "--at", "1,2,3"},
      {"replay", "a.log", "--map", "m", "--at", "1,2"},
      {"replay", "a.log", "--map", "m", "--robot", "Robot 1"},
      {"replay", "a.log", "--map", "m", "--session", "-x-"},
      {"replay", "a.log", "--map", "m", "--spool-mib", "0.5"},
      {"replay", "a.log", "--map", "m", "--rate", "slow"},
      {"completion", "fish"},
      {"fly"},
  };
  for (const auto& arguments : cases) {
    EXPECT_CODE(Run(arguments), absl::StatusCode::kInvalidArgument) << ::testing::PrintToString(arguments);
  }
  for (const auto& call : server_.calls()) EXPECT_TRUE(call.seconds_to_live.has_value());  // at most looked for a map
}

TEST_F(ServerCommandsTest, MissingFilesAreFoundOutBeforeTheCall) {
  for (const auto& arguments : std::vector<std::vector<std::string>>{{"map", "import", "/none/a.yaml", "--map", "m"},
                                                                     {"import", "mapmanager", "/none/a.db"},
                                                                     {"import", "building", "/none/b.yaml"},
                                                                     {"replay", "/none/a.log", "--map", "m"}}) {
    EXPECT_CODE(Run(arguments), absl::StatusCode::kNotFound) << arguments[0];
  }
  EXPECT_TRUE(server_.calls().empty());
}

TEST_F(ServerCommandsTest, MapsAreListedForProgramsAndForPeople) {
  ASSERT_OK(Run({"map", "list"}));
  ASSERT_EQ(Printed().size(), 2U);
  EXPECT_EQ(Printed()[0]["name"], "sites/s/maps/h");
  EXPECT_EQ(Printed()[1]["environment"], "outdoor");
  EXPECT_EQ(Printed()[1]["latest_revision"], "sites/s/maps/l/revisions/4");
  ASSERT_OK(Run({"map", "list"}, false));
  EXPECT_EQ(printed_,
            "MAP  NAME  LEVEL  ENVIRONMENT  REVISION  CREATED (UTC)\n"
            "h    Hall  0      indoor       -         \n"
            "l    Lab   1      outdoor      4         \n");
  EXPECT_EQ(server_.calls().front().actor, "ann");
}

TEST_F(ServerCommandsTest, AMapIsShownWithItsNewestRevisions) {
  int asked = 0;
  server_.maps.list_revisions = [&](const v1::ListMapRevisionsRequest& request,
                                    v1::ListMapRevisionsResponse& response) {
    EXPECT_EQ(request.parent(), "sites/s/maps/h");
    asked = request.page_size();
    v1::MapRevision& revision = *response.add_revisions();
    revision.set_name("sites/s/maps/h/revisions/2");
    revision.set_session("sites/s/sessions/run");
    revision.set_width(30);
    revision.set_height(20);
    revision.set_resolution_m(0.05);
    revision.set_content_sha256(Sha256("x"));
    revision.mutable_create_time()->set_seconds(1'700'000'000);
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"map", "show", "Hall"}));
  EXPECT_EQ(asked, 10);
  const json document = Printed();
  EXPECT_EQ(document["display_name"], "Hall");
  ASSERT_EQ(document["revisions"].size(), 1U);
  EXPECT_EQ(document["revisions"][0]["content_sha256"], ToHex(Sha256("x")));
  EXPECT_EQ(document["revisions"][0]["create_time"], "2023-11-14 22:13:20");
  ASSERT_OK(Run({"map", "show", "Hall"}, false));
  EXPECT_THAT(printed_, HasSubstr("2         session run  30 x 20 cells of 0.05 m  2023-11-14 22:13:20"));
  EXPECT_STATUS(Run({"map", "show", "Cellar"}), absl::StatusCode::kNotFound, HasSubstr("Cellar"));
}

TEST_F(ServerCommandsTest, AMapIsCreatedAndUpdatedFieldByField) {
  v1::CreateMapRequest created;
  server_.maps.create_map = [&](const v1::CreateMapRequest& request, v1::CreateMapResponse& response) {
    created = request;
    response.mutable_map()->set_name("sites/s/maps/attic");
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"map", "create", "Attic", "--id", "attic", "--level", "3", "--environment", "outdoor", "--outline",
                 "0", "0", "4", "0", "4", "5"}));
  EXPECT_EQ(created.parent(), "sites/s");
  EXPECT_EQ(created.map_id(), "attic");
  EXPECT_FALSE(created.request_id().empty());
  EXPECT_EQ(created.map().level(), 3);
  EXPECT_EQ(created.map().environment(), v1::Map::ENVIRONMENT_OUTDOOR);
  ASSERT_EQ(created.map().outline().corners_size(), 3);
  EXPECT_EQ(created.map().outline().corners(2).y(), 5.0);
  EXPECT_EQ(Printed()["name"], "sites/s/maps/attic");

  v1::UpdateMapRequest updated;
  server_.maps.update_map = [&](const v1::UpdateMapRequest& request, v1::UpdateMapResponse& response) {
    updated = request;
    *response.mutable_map() = request.map();
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"map", "update", "Hall", "--level", "-1", "--name", "Vault"}));
  EXPECT_EQ(updated.map().name(), "sites/s/maps/h");
  EXPECT_EQ(updated.map().etag(), "e-Hall") << "so that no other change is overwritten";
  EXPECT_THAT(std::vector<std::string>(updated.update_mask().paths().begin(), updated.update_mask().paths().end()),
              ElementsAre("display_name", "level"));
  EXPECT_STATUS(Run({"map", "update", "Hall"}), absl::StatusCode::kInvalidArgument, HasSubstr("nothing to change"));
}

TEST_F(ServerCommandsTest, DeletingNamesTheMapAndItsEtag) {
  v1::DeleteMapRequest deleted;
  server_.maps.delete_map = [&](const v1::DeleteMapRequest& request, v1::DeleteMapResponse&) {
    deleted = request;
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"map", "delete", "Lab", "--force"}, false));
  EXPECT_EQ(deleted.name(), "sites/s/maps/l");
  EXPECT_EQ(deleted.etag(), "e-Lab");
  EXPECT_TRUE(deleted.force());
  EXPECT_EQ(printed_, "deleted \"Lab\" (sites/s/maps/l)\n");
}

TEST_F(ServerCommandsTest, ARevisionIsExportedByItsResourceNameWithoutALookup) {
  std::string exported;
  server_.maps.export_map = [&](const v1::ExportMapRequest& request,
                                grpc::ServerWriter<v1::ExportMapResponse>& writer) {
    exported = request.name();
    v1::ExportMapResponse manifest;
    manifest.mutable_manifest()->mutable_revision()->set_name(request.name());
    enfilade::testing::AddToManifest("a.json", "{}", *manifest.mutable_manifest());
    writer.Write(manifest);
    writer.Write(enfilade::testing::ChunkOf<v1::ExportMapResponse>(0, 0, "{}"));
    return grpc::Status::OK;
  };
  const std::string out = directory_.path() / "out";
  ASSERT_OK(Run({"map", "export", "sites/s/maps/h/revisions/2", "-o", out, "--format", "json"}));
  EXPECT_EQ(exported, "sites/s/maps/h/revisions/2");
  EXPECT_EQ(server_.calls().size(), 1U);
  EXPECT_EQ(Printed()["files"], json::array({out + "/a.json"}));
  EXPECT_EQ(Printed()["bytes"], 2);
  EXPECT_EQ(Content(out + "/a.json"), "{}");
}

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

class GraphCommandsTest : public ServerCommandsTest {
 protected:
  GraphCommandsTest() {
    server_.graph.get_graph = [](const v1::GetGraphRequest& request, v1::GetGraphResponse& response) {
      v1::Graph& graph = *response.mutable_graph();
      graph.set_graph_version(request.graph_version() == 0 ? 9 : request.graph_version());
      for (const std::string map : {"h", "l", "x"}) graph.add_maps()->set_map("sites/s/maps/" + map);
      graph.mutable_maps(1)->mutable_pose_world_map()->mutable_pose()->set_x(8.0);
      graph.mutable_maps(1)->set_optimized(true);
      v1::GraphLinkPoint& point = *graph.add_link_points();
      point.set_link_point("sites/s/linkPoints/door");
      point.add_maps("sites/s/maps/h");
      return grpc::Status::OK;
    };
  }
};

TEST_F(GraphCommandsTest, ShowsMapsThatAreNotJoinedAndCandidates) {
  ASSERT_OK(Run({"graph", "show", "--version", "4"}, false));
  EXPECT_THAT(printed_, HasSubstr("graph version 4: 3 maps, 1 link points, 0 edges; root -"));
  EXPECT_THAT(printed_, HasSubstr("8.000 0.000 0.0000  optimised"));
  EXPECT_THAT(printed_, HasSubstr("not joined"));
  EXPECT_THAT(printed_, HasSubstr("door        h     not joined     candidate"));
  ASSERT_OK(Run({"graph", "show"}));
  EXPECT_EQ(Printed()["graph_version"], 9);
  EXPECT_FALSE(Printed()["maps"][0].contains("pose_world_map"));
}

TEST_F(GraphCommandsTest, VersionsNameCausesAndWhatOptimisationFound) {
  server_.graph.list_versions = [](const v1::ListGraphVersionsRequest& request,
                                   v1::ListGraphVersionsResponse& response) {
    for (int i = 0; i < std::min(request.page_size(), 3); ++i) {
      v1::GraphVersion& version = *response.add_graph_versions();
      version.set_graph_version(10 - i);
      version.set_cause(v1::GraphVersion::CAUSE_OPTIMIZED);
      version.set_chi2_before(12.5);
      version.add_switched_off("sites/s/linkPoints/door");
    }
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"graph", "versions", "--count", "2"}));
  EXPECT_EQ(Printed().size(), 2U);
  EXPECT_EQ(Printed()[0]["cause"], "optimized");
  ASSERT_OK(Run({"graph", "versions"}, false));
  EXPECT_THAT(printed_, HasSubstr("chi2 12.5 -> 0, 1 switched off"));
}

TEST_F(GraphCommandsTest, OptimisingReportsWhatWasSwitchedOff) {
  server_.graph.optimize = [](const v1::OptimizeGraphRequest&, v1::OptimizeGraphResponse& response) {
    response.set_maps(3);
    response.set_converged(false);
    response.add_switched_off()->set_link_point("sites/s/linkPoints/door");
    response.add_disconnected_maps("sites/s/maps/x");
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"graph", "optimize"}, false));
  EXPECT_THAT(printed_, HasSubstr("3 maps placed"));
  EXPECT_THAT(printed_, HasSubstr("not converged"));
  EXPECT_THAT(printed_, HasSubstr("switched off door"));
  EXPECT_THAT(printed_, HasSubstr("not joined to the root: x"));
}

TEST_F(GraphCommandsTest, ThePlotOfAMapWithoutFilesIsItsAxes) {
  server_.maps.get_map = [](const v1::GetMapRequest& request, v1::GetMapResponse& response) {
    response.mutable_map()->set_name(request.name());
    return grpc::Status::OK;
  };
  server_.maps.export_map = [](const v1::ExportMapRequest&, auto&) {
    return grpc::Status(grpc::StatusCode::FAILED_PRECONDITION, "no revision");
  };
  const std::string svg = directory_.path() / "g.svg";
  ASSERT_OK(Run({"graph", "plot", "-o", svg}));
  EXPECT_EQ(Printed()["maps"], 1) << "only one map has a pose in the world";
  EXPECT_EQ(Printed()["grids"], 0);
  EXPECT_THAT(Content(svg), HasSubstr("<svg"));
  server_.maps.export_map = [](const v1::ExportMapRequest&, auto&) {
    return grpc::Status(grpc::StatusCode::INTERNAL, "broken");
  };
  EXPECT_CODE(Run({"graph", "plot", "-o", svg}), absl::StatusCode::kInternal);
}

TEST_F(GraphCommandsTest, AGlobalPoseComesFromARobotOrAPoseInAMap) {
  v1::GetGlobalPoseRequest asked;
  server_.graph.get_global_pose = [&](const v1::GetGlobalPoseRequest& request, v1::GetGlobalPoseResponse& response) {
    asked = request;
    v1::GlobalPose& pose = *response.mutable_global_pose();
    pose.set_search_radius_m(12.5);
    if (!request.robot().empty()) pose.set_robot(request.robot());
    if (!request.robot().empty()) return grpc::Status::OK;
    v1::PoseWithCovariance& world = *pose.mutable_pose_world_robot();
    world.mutable_pose()->set_x(2.0);
    for (const double value : {0.04, 0.0, 0.0, 0.0, 0.09, 0.0, 0.0, 0.0, 0.01}) world.add_covariance(value);
    pose.add_hops()->set_link_point("sites/s/linkPoints/door");
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"pose", "global", "--at", "Lab,1,2,0.5"}, false));
  EXPECT_EQ(asked.map_pose().map(), "sites/s/maps/l");
  EXPECT_THAT(printed_, HasSubstr("x 2.000 m, y 0.000 m, yaw 0.0000 rad  (sigma 0.200 m, 0.300 m, 0.1000 rad)"));
  EXPECT_THAT(printed_, HasSubstr("through door"));
  EXPECT_THAT(printed_, HasSubstr("search radius 12.50 m"));
  ASSERT_OK(Run({"pose", "global", "--robot", "r1"}, false));
  EXPECT_EQ(asked.robot(), "sites/s/robots/r1");
  EXPECT_THAT(printed_, HasSubstr("no link points join its map to the root"));
}

TEST_F(GraphCommandsTest, WatchedPosesAreOneLineEach) {
  server_.graph.watch_global_poses = [](const v1::WatchGlobalPosesRequest& request,
                                        grpc::ServerWriter<v1::WatchGlobalPosesResponse>& writer) {
    EXPECT_EQ(request.robots(0), "sites/s/robots/r1");
    EXPECT_EQ(request.rate_hz(), 5.0);
    v1::WatchGlobalPosesResponse response;
    for (const char* robot : {"r1", "r2"}) response.add_global_poses()->set_robot(robot);
    writer.Write(response);
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"pose", "watch", "--robot", "r1", "--rate", "5"}));
  EXPECT_EQ(std::count(printed_.begin(), printed_.end(), '\n'), 2);
  EXPECT_EQ(json::parse(printed_.substr(0, printed_.find('\n')))["robot"], "r1");
}

TEST_F(GraphCommandsTest, RoutesAreAskedForByCost) {
  v1::FindRoutesRequest asked;
  bool any = true;
  server_.graph.find_routes = [&](const v1::FindRoutesRequest& request, v1::FindRoutesResponse& response) {
    asked = request;
    response.set_geojson("{}");
    if (!any) return grpc::Status::OK;
    v1::Route& route = *response.add_routes();
    route.set_length_m(10.0);
    route.add_legs()->set_exit("sites/s/linkPoints/door");
    route.add_legs()->set_map("sites/s/maps/l");
    return grpc::Status::OK;
  };
  const std::pair<std::string, v1::PathCost> costs[] = {
      {"distance", v1::PATH_COST_DISTANCE}, {"hops", v1::PATH_COST_HOPS}, {"uncertainty", v1::PATH_COST_UNCERTAINTY}};
  for (const auto& [name, cost] : costs) {
    ASSERT_OK(Run({"route", "Hall,1,2", "Lab,3,4", "--cost", name, "--alternatives", "3"}));
    EXPECT_EQ(asked.cost(), cost);
  }
  EXPECT_EQ(asked.start_map(), "sites/s/maps/h");
  EXPECT_EQ(asked.pose_map_goal().y(), 4.0);
  EXPECT_EQ(asked.max_routes(), 3);
  EXPECT_EQ(Printed()["routes"][0]["legs"].size(), 2U);
  ASSERT_OK(Run({"route", "Hall,1,2", "Lab,3,4"}, false));
  EXPECT_THAT(printed_, HasSubstr("door"));
  EXPECT_THAT(printed_, HasSubstr("goal"));
  ASSERT_OK(Run({"route", "Hall,1,2", "Lab,3,4", "--geojson"}));
  EXPECT_EQ(printed_, "{}\n");
  any = false;
  ASSERT_OK(Run({"route", "Hall,1,2", "Lab,3,4"}, false));
  EXPECT_THAT(printed_, HasSubstr("no route"));
}

TEST_F(ServerCommandsTest, TheServersErrorsKeepTheirCodes) {
  for (const auto code :
       {grpc::StatusCode::NOT_FOUND, grpc::StatusCode::ABORTED, grpc::StatusCode::DEADLINE_EXCEEDED}) {
    server_.maps.list_maps = [=](const auto&, auto&) { return grpc::Status(code, "why"); };
    EXPECT_STATUS(Run({"map", "list"}), static_cast<absl::StatusCode>(code), HasSubstr("why"));
  }
  server_.Stop();
  EXPECT_STATUS(Run({"map", "list"}), absl::StatusCode::kUnavailable, HasSubstr(server_.address()));
}

TEST_F(ServerCommandsTest, CompletionKnowsEveryCommandAndOption) {
  ASSERT_OK(Run({"completion", "bash"}));
  EXPECT_THAT(printed_, HasSubstr("'map export') words='--help --output --format "));
  EXPECT_THAT(printed_, HasSubstr("graph.plot"));
  EXPECT_THAT(printed_, Not(HasSubstr("bashcompinit")));
  ASSERT_OK(Run({"completion", "zsh"}));
  EXPECT_THAT(printed_, HasSubstr("bashcompinit"));
}

}  // namespace
}  // namespace enfilade::cli
