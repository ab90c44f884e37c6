// SPDX-License-Identifier: Apache-2.0
// Commands that call a server: what they refuse, and those for maps.
#include "core/base/sha256.h"
#include "tests/unit/client/cli/server_commands_fixture.h"

namespace enfilade::cli {
namespace {

using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

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
      {"map", "draft"},
      {"map", "draft", "create"},
      {"map", "draft", "show", "Hall"},
      {"map", "draft", "undo", "Hall", "d"},
      {"map", "edit", "Hall"},
      {"map", "publish", "Hall", "d"},
      {"map", "publish", "Hall", "--dry-run"},
      {"map", "rebase", "Hall"},
      {"map", "contested"},
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
  EXPECT_THAT(printed_, HasSubstr("'map export') words='--help --revision --output --format "));
  EXPECT_THAT(printed_, HasSubstr("graph.plot"));
  EXPECT_THAT(printed_, Not(HasSubstr("bashcompinit")));
  ASSERT_OK(Run({"completion", "zsh"}));
  EXPECT_THAT(printed_, HasSubstr("bashcompinit"));
}

TEST_F(ServerCommandsTest, EachCommandHasAManualPage) {
  ASSERT_OK(Run({"manual", directory_.path()}));
  const std::string map = Content(directory_.path() / "enfilade-map.1");
  EXPECT_THAT(map, HasSubstr(".SS \\fBenfilade map export\\fR [\\fIOPTIONS\\fR] \\fIMAP\\fR\n"));
  EXPECT_THAT(map, HasSubstr("\\fB\\-\\-format\\fR \\fITEXT\\fR\npgm or png"));
  const std::string all = Content(directory_.path() / "enfilade.1");
  EXPECT_THAT(all, HasSubstr("enfilade\\-map(1)"));
  EXPECT_THAT(all, Not(HasSubstr(".SS")));
}

}  // namespace
}  // namespace enfilade::cli
