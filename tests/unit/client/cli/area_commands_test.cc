// SPDX-License-Identifier: Apache-2.0
// Commands for the areas of a map: what they ask for, and what they print.
#include "core/areas/area_geojson.h"
#include "tests/unit/client/cli/server_commands_fixture.h"

namespace enfilade::cli {
namespace {

using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

v1::MapArea Ramp() {
  v1::MapArea area;
  area.set_name("sites/s/maps/h/areas/ramp");
  area.set_display_name("Ramp");
  area.set_kind(v1::MapArea::KIND_SPEED_LIMIT);
  for (const auto& [x, y] : std::vector<std::pair<double, double>>{{0, 0}, {4.5, 0}, {4, -2}}) {
    v1::Point& corner = *area.mutable_outline()->add_corners();
    corner.set_x(x);
    corner.set_y(y);
  }
  area.add_robot_types("cleaner");
  area.add_robot_types("forklift");
  area.set_speed_limit_mps(0.3);
  area.mutable_valid_from()->set_seconds(1'767'225'600);  // 2026-01-01
  area.set_etag("e-ramp");
  return area;
}

// The map Hall (sites/s/maps/h) has one area, "Ramp".
class AreaCommandsTest : public ServerCommandsTest {
 protected:
  AreaCommandsTest() {
    server_.map_areas.list = [](const v1::ListMapAreasRequest& request, v1::ListMapAreasResponse& response) {
      if (request.parent() == "sites/s/maps/h") *response.add_areas() = Ramp();
      return grpc::Status::OK;
    };
    server_.map_areas.get = [](const v1::GetMapAreaRequest& request, v1::GetMapAreaResponse& response) {
      if (request.name() != Ramp().name()) return grpc::Status(grpc::StatusCode::NOT_FOUND, "no area");
      *response.mutable_area() = Ramp();
      return grpc::Status::OK;
    };
    server_.map_areas.create = [this](const v1::CreateMapAreaRequest& request, v1::CreateMapAreaResponse& response) {
      created_.push_back(request);
      *response.mutable_area() = request.area();
      response.mutable_area()->set_name(request.parent() + "/areas/new");
      return grpc::Status::OK;
    };
    server_.map_areas.update = [this](const v1::UpdateMapAreaRequest& request, v1::UpdateMapAreaResponse& response) {
      updated_ = request;
      *response.mutable_area() = request.area();
      return grpc::Status::OK;
    };
  }
  absl::Status Run(std::vector<std::string> arguments, bool as_json = true) {
    const auto add = [](CLI::App& app, const Globals& globals) { AddArea(app, globals); };
    arguments.insert(arguments.begin(), "area");
    return RunCommandLine(add, std::move(arguments), as_json);
  }

  std::vector<v1::CreateMapAreaRequest> created_;
  v1::UpdateMapAreaRequest updated_;
};

TEST_F(AreaCommandsTest, BadArgumentsAreRefusedBeforeTheCall) {
  const std::string file = File("areas.geojson", "{}");
  for (const auto& arguments : std::vector<std::vector<std::string>>{
           {},
           {"list"},
           {"add", "Hall"},
           {"add", "Hall", "--kind", "keep-out"},
           {"add", "Hall", "--polygon", "0,0 1,0 1,1"},
           {"add", "Hall", "--kind", "lava", "--polygon", "0,0 1,0 1,1"},
           {"add", "Hall", "--kind", "room", "--polygon", "0,0 1;0 1,1"},
           {"add", "Hall", "--kind", "room", "--polygon", "0,0 1,0 nan,1"},
           {"add", "Hall", "--kind", "room", "--polygon", "0,0 1,0 1,1", "--from", "tomorrow"},
           {"add", "Hall", "--kind", "room", "--polygon", "0,0 1,0 1,1", "--until", "infinite-future"},
           {"add", "Hall", "--kind", "room", "--polygon", "0,0 1,0 1,1", "--file", file},
           {"add", "Hall", "--file", file, "--name", "N"},
           {"add", "Hall", "--file", file, "--id", "i"},
           {"show", "Hall"},
           {"update", "Hall", "Ramp"},
           {"delete", "Hall"},
           {"export", "Hall"},
           {"export", "Hall", "-o", "o", "--format", "shapefile"},
           {"export", "Hall", "-o", "o", "--at", "noon"}}) {
    EXPECT_CODE(Run(arguments), absl::StatusCode::kInvalidArgument) << ::testing::PrintToString(arguments);
  }
  EXPECT_TRUE(server_.calls().empty());
}

TEST_F(AreaCommandsTest, AddSendsWhatWasGiven) {
  ASSERT_OK(Run({"add",          "Hall",
                 "--kind",       "speed-limit",
                 "--polygon",    "-1.5,0 4,0  4,2.25",
                 "--name",       "Ramp",
                 "--id",         "ramp",
                 "--speed",      "0.3",
                 "--robot-type", "forklift",
                 "--robot-type", "cleaner",
                 "--from",       "2026-01-01T01:00:00+01:00",
                 "--until",      "2026-02-01T00:00:00.5Z",
                 "--force"},
                false));
  ASSERT_EQ(created_.size(), 1U);
  const v1::CreateMapAreaRequest& request = created_[0];
  EXPECT_EQ(request.parent(), "sites/s/maps/h");
  EXPECT_EQ(request.area_id(), "ramp");
  EXPECT_TRUE(request.force());
  EXPECT_FALSE(request.request_id().empty());
  EXPECT_EQ(request.area().kind(), v1::MapArea::KIND_SPEED_LIMIT);
  EXPECT_EQ(request.area().display_name(), "Ramp");
  EXPECT_EQ(request.area().speed_limit_mps(), 0.3);
  EXPECT_THAT(request.area().robot_types(), ElementsAre("forklift", "cleaner"));
  ASSERT_EQ(request.area().outline().corners_size(), 3);
  EXPECT_EQ(request.area().outline().corners(0).x(), -1.5);
  EXPECT_EQ(request.area().outline().corners(2).y(), 2.25);
  EXPECT_EQ(request.area().valid_from().seconds(), 1'767'225'600);
  EXPECT_EQ(request.area().valid_until().nanos(), 500'000'000);
  EXPECT_EQ(printed_, "added speed-limit \"Ramp\" (sites/s/maps/h/areas/new)\n");
  ASSERT_OK(Run({"add", "Hall", "--kind", "keep-out", "--polygon", "0,0 1,0 1,1"}));
  EXPECT_EQ(created_[1].area().display_name(), "keep-out") << "its kind is its name";
  EXPECT_FALSE(created_[1].force());
  EXPECT_FALSE(created_[1].area().has_valid_from());
  EXPECT_EQ(Printed()["kind"], "keep-out");
  EXPECT_EQ(Printed()["outline"], json::array({{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}}));
}

TEST_F(AreaCommandsTest, AddSendsEachAreaOfAFile) {
  areas::NamedArea bench{MapAreaId("bench"), {}};
  bench.area.kind = areas::AreaKind::kRoom;
  bench.area.display_name = "Bench";
  bench.area.outline = {{0, 0}, {1, 0}, {1, 1}};
  areas::NamedArea slow = bench;
  slow.id = MapAreaId();
  slow.area.kind = areas::AreaKind::kSpeedLimit;
  slow.area.speed_limit_mps = 0.5;
  slow.area.robot_types = {"forklift"};
  slow.area.valid_until = 1'767'225'600'000'000'000;
  const std::string file = File("areas.geojson", areas::WriteAreasGeoJson({bench, slow}));
  ASSERT_OK(Run({"add", "Hall", "--file", file}));
  ASSERT_EQ(created_.size(), 2U);
  EXPECT_EQ(created_[0].area_id(), "bench");
  EXPECT_EQ(created_[0].area().kind(), v1::MapArea::KIND_ROOM);
  EXPECT_EQ(created_[1].area_id(), "");
  EXPECT_EQ(created_[1].area().speed_limit_mps(), 0.5);
  EXPECT_EQ(created_[1].area().valid_until().seconds(), 1'767'225'600);
  EXPECT_NE(created_[0].request_id(), created_[1].request_id());
  EXPECT_EQ(Printed().size(), 2U);

  server_.map_areas.create = [](const v1::CreateMapAreaRequest& request, v1::CreateMapAreaResponse&) {
    if (request.area_id() == "bench") return grpc::Status::OK;
    return grpc::Status(grpc::StatusCode::RESOURCE_EXHAUSTED, "full");
  };
  EXPECT_STATUS(Run({"add", "Hall", "--file", file}), absl::StatusCode::kResourceExhausted,
                HasSubstr("feature 1 (those before it are stored): "));
  EXPECT_STATUS(Run({"add", "Hall", "--file", File("bad.geojson", "{\"type\": 3}")}),
                absl::StatusCode::kInvalidArgument, HasSubstr("bad.geojson: not a GeoJSON FeatureCollection"));
  EXPECT_CODE(Run({"add", "Hall", "--file", "/none/areas.geojson"}), absl::StatusCode::kNotFound);
}

TEST_F(AreaCommandsTest, AreasAreListedAndShown) {
  ASSERT_OK(Run({"list", "Hall"}, false));
  EXPECT_EQ(printed_,
            "AREA  NAME  KIND         SPEED    ROBOTS             HOLDS\n"
            "ramp  Ramp  speed-limit  0.3 m/s  cleaner, forklift  from 2026-01-01 00:00:00 UTC\n");
  ASSERT_OK(Run({"list", "Hall"}));
  EXPECT_EQ(Printed()[0]["name"], "sites/s/maps/h/areas/ramp");
  EXPECT_EQ(Printed()[0]["valid_from"], "2026-01-01 00:00:00");
  for (const char* name : {"ramp", "Ramp", "sites/s/maps/h/areas/ramp"}) {
    ASSERT_OK(Run({"show", "Hall", name}, false)) << name;
    EXPECT_EQ(printed_,
              "Ramp\n"
              "sites/s/maps/h/areas/ramp  speed-limit, 0.3 m/s\n"
              "robots: cleaner, forklift\n"
              "holds: from 2026-01-01 00:00:00 UTC\n"
              "corners: 0,0 4.5,0 4,-2\n");
  }
  EXPECT_STATUS(Run({"show", "Hall", "Stairs"}), absl::StatusCode::kNotFound, HasSubstr("\"Stairs\""));
}

TEST_F(AreaCommandsTest, ANameThatTwoAreasHaveIsRefused) {
  server_.map_areas.list = [](const v1::ListMapAreasRequest&, v1::ListMapAreasResponse& response) {
    *response.add_areas() = Ramp();
    *response.add_areas() = Ramp();
    response.mutable_areas(1)->set_name("sites/s/maps/h/areas/other");
    return grpc::Status::OK;
  };
  EXPECT_STATUS(Run({"delete", "Hall", "Ramp"}), absl::StatusCode::kFailedPrecondition, HasSubstr("areas/other"));
}

TEST_F(AreaCommandsTest, UpdateNamesTheFieldsThatWereGiven) {
  ASSERT_OK(
      Run({"update", "Hall", "Ramp", "--speed", "0.5", "--from", "none", "--all-robots", "--name", "Slope"}, false));
  EXPECT_EQ(updated_.area().name(), "sites/s/maps/h/areas/ramp");
  EXPECT_EQ(updated_.area().etag(), "e-ramp");
  EXPECT_THAT(updated_.update_mask().paths(),
              ElementsAre("display_name", "robot_types", "speed_limit_mps", "valid_from"));
  EXPECT_FALSE(updated_.area().has_valid_from());
  EXPECT_EQ(updated_.area().robot_types_size(), 0);
  EXPECT_EQ(updated_.area().speed_limit_mps(), 0.5);
  EXPECT_FALSE(updated_.force());
  EXPECT_THAT(printed_, HasSubstr("updated "));
}

TEST_F(AreaCommandsTest, DeleteGivesTheEtag) {
  v1::DeleteMapAreaRequest asked;
  server_.map_areas.remove = [&](const v1::DeleteMapAreaRequest& request, v1::DeleteMapAreaResponse&) {
    asked = request;
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"delete", "Hall", "ramp"}, false));
  EXPECT_EQ(asked.name(), "sites/s/maps/h/areas/ramp");
  EXPECT_EQ(asked.etag(), "e-ramp");
  EXPECT_EQ(printed_, "deleted \"Ramp\" (sites/s/maps/h/areas/ramp)\n");
}

TEST_F(AreaCommandsTest, ExportWritesTheFiles) {
  v1::ExportMapAreasRequest asked;
  server_.map_areas.export_files = [&](const v1::ExportMapAreasRequest& request,
                                       grpc::ServerWriter<v1::ExportMapAreasResponse>& writer) {
    asked = request;
    v1::ExportMapAreasResponse manifest;
    enfilade::testing::AddToManifest("keepout.pgm", "pgm", *manifest.mutable_manifest());
    writer.Write(manifest);
    writer.Write(enfilade::testing::ChunkOf<v1::ExportMapAreasResponse>(0, 0, "pgm"));
    return grpc::Status::OK;
  };
  const std::string out = directory_.path() / "out";
  ASSERT_OK(Run({"export", "Hall", "-o", out, "--format", "nav2-keepout", "--robot-type", "forklift", "--at",
                 "2026-01-01T00:00:00Z"}));
  EXPECT_EQ(asked.parent(), "sites/s/maps/h");
  EXPECT_EQ(asked.format(), v1::MAP_AREA_FORMAT_NAV2_KEEPOUT);
  EXPECT_EQ(asked.robot_type(), "forklift");
  EXPECT_EQ(asked.time().seconds(), 1'767'225'600);
  EXPECT_EQ(Printed()["files"], json::array({out + "/keepout.pgm"}));
  EXPECT_EQ(Content(out + "/keepout.pgm"), "pgm");
  ASSERT_OK(Run({"export", "Hall", "-o", out}, false));
  EXPECT_EQ(asked.format(), v1::MAP_AREA_FORMAT_GEOJSON);
  EXPECT_FALSE(asked.has_time());
}

}  // namespace
}  // namespace enfilade::cli
