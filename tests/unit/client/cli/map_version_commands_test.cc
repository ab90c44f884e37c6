// SPDX-License-Identifier: Apache-2.0
// Commands for aliases, differences and restored revisions: what they ask for, and what they print.
#include "core/grid/files/png_codec.h"
#include "tests/unit/client/cli/server_commands_fixture.h"

namespace enfilade::cli {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr char kLab[] = "sites/s/maps/l";

// The map Lab has the newest revision 4, and the alias stable, which leads to 2.
class MapVersionCommandsTest : public ServerCommandsTest {
 protected:
  MapVersionCommandsTest() {
    server_.maps.list_aliases = [](const v1::ListMapAliasesRequest& request, v1::ListMapAliasesResponse& response) {
      if (request.parent() == kLab) *response.add_aliases() = Stable(2, 1);
      return grpc::Status::OK;
    };
    server_.maps.get_revision = [](const v1::GetMapRevisionRequest& request, v1::GetMapRevisionResponse& response) {
      response.mutable_revision()->set_name(request.name().ends_with("stable") ? std::string(kLab) + "/revisions/2"
                                                                               : request.name());
      return grpc::Status::OK;
    };
    server_.maps.set_alias = [this](const v1::SetMapAliasRequest& request, v1::SetMapAliasResponse& response) {
      set_ = request.alias();
      *response.mutable_alias() = request.alias();
      return grpc::Status::OK;
    };
    server_.maps.diff_revisions = [this](const v1::DiffMapRevisionsRequest& request,
                                         v1::DiffMapRevisionsResponse& response) {
      diff_ = request;
      response.set_base(std::string(kLab) + "/revisions/2");
      response.set_revision(std::string(kLab) + "/revisions/4");
      response.set_resolution_m(0.05);
      for (const int count : {100, 1, 2, 3, 200, 30, 5, 6, 50}) response.add_cells(count);
      response.set_region_count(2);
      v1::MapDiffRegion& region = *response.add_regions();
      for (const auto& [x, y] : {std::pair(1.0, 2.0), {3.0, 2.0}, {3.0, 2.5}, {1.0, 2.5}}) {
        v1::Point& corner = *region.mutable_box()->add_corners();
        corner.set_x(x);
        corner.set_y(y);
      }
      region.set_cells(32);
      region.set_to_occupied(32);
      response.set_picture("png");
      response.set_geojson("{}");
      return grpc::Status::OK;
    };
  }
  static v1::MapAlias Stable(int revision, int before) {
    v1::MapAlias alias;
    alias.set_name(std::string(kLab) + "/aliases/stable");
    alias.set_revision(std::string(kLab) + "/revisions/" + std::to_string(revision));
    alias.set_previous_revision(std::string(kLab) + "/revisions/" + std::to_string(before));
    alias.set_etag("e-2");
    alias.set_actor("eve");
    return alias;
  }
  // A map of one pillar, 40 x 30 cells of 0.1 m.
  std::string MapFile(const std::string& name, int pillar) const {
    std::string pixels(40 * 30, '\xfe');
    for (int row = 10; row < 13; ++row) pixels[static_cast<std::size_t>(row * 40 + pillar)] = '\0';
    File(name + ".pgm", "P5\n40 30\n255\n" + pixels);
    return File(name + ".yaml", "image: " + name +
                                    ".pgm\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\n"
                                    "free_thresh: 0.196\n");
  }

  v1::MapAlias set_;
  v1::DiffMapRevisionsRequest diff_;
};

TEST_F(MapVersionCommandsTest, BadArgumentsAreRefusedBeforeTheCall) {
  for (const auto& arguments : std::vector<std::vector<std::string>>{{"diff", "Lab"},
                                                                     {"diff", "Lab", "lab.yaml"},
                                                                     {"diff", "Lab", "@2", "--regions", "0"},
                                                                     {"diff", "Lab", "@2", "--resolution", "0.1"},
                                                                     {"alias"},
                                                                     {"alias", "set", "Lab"},
                                                                     {"alias", "rollback", "Lab"},
                                                                     {"restore", "Lab"}}) {
    std::vector<std::string> command = arguments;
    command.insert(command.begin(), "map");
    EXPECT_CODE(Run(command), absl::StatusCode::kInvalidArgument) << ::testing::PrintToString(arguments);
  }
  EXPECT_TRUE(server_.calls().empty());
  EXPECT_CODE(Run({"map", "diff", "Lab@", "Lab"}), absl::StatusCode::kInvalidArgument);
}

TEST_F(MapVersionCommandsTest, AnAliasIsSetUnderTheEtagThatItHas) {
  ASSERT_OK(Run({"map", "alias", "set", "Lab", "stable", "--revision", "3"}));
  EXPECT_EQ(set_.name(), std::string(kLab) + "/aliases/stable");
  EXPECT_EQ(set_.revision(), std::string(kLab) + "/revisions/3");
  EXPECT_EQ(set_.etag(), "e-2");
  ASSERT_OK(Run({"map", "alias", "set", "Lab", "canary"}));
  EXPECT_EQ(set_.revision(), std::string(kLab) + "/revisions/4") << "the newest";
  EXPECT_EQ(set_.etag(), "");
  ASSERT_OK(Run({"map", "alias", "set", "Lab", "canary", "--revision", "stable", "--etag", "mine"}));
  EXPECT_EQ(set_.revision(), std::string(kLab) + "/revisions/2") << "where another alias leads";
  EXPECT_EQ(set_.etag(), "mine");
  EXPECT_CODE(Run({"map", "alias", "set", "Hall", "stable"}), absl::StatusCode::kFailedPrecondition);
}

TEST_F(MapVersionCommandsTest, AliasesAreListedLedBackAndDeleted) {
  ASSERT_OK(Run({"map", "alias", "list", "Lab"}, false));
  EXPECT_THAT(printed_, HasSubstr("stable  2         1       eve"));
  v1::RollBackMapAliasRequest back;
  server_.maps.roll_back_alias = [&](const v1::RollBackMapAliasRequest& request,
                                     v1::RollBackMapAliasResponse& response) {
    back = request;
    *response.mutable_alias() = Stable(1, 2);
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"map", "alias", "rollback", "Lab", "stable", "--etag", "e-2"}, false));
  EXPECT_EQ(back.name(), std::string(kLab) + "/aliases/stable");
  EXPECT_EQ(back.etag(), "e-2");
  EXPECT_THAT(printed_, HasSubstr("stable leads to sites/s/maps/l/revisions/1, before to revision 2"));
  v1::DeleteMapAliasRequest deletion;
  server_.maps.delete_alias = [&](const v1::DeleteMapAliasRequest& request, v1::DeleteMapAliasResponse&) {
    deletion = request;
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"map", "alias", "delete", "Lab", "stable"}));
  EXPECT_EQ(deletion.name(), std::string(kLab) + "/aliases/stable");
}

TEST_F(MapVersionCommandsTest, RestoresARevisionByNumberOrAlias) {
  std::vector<std::string> names;
  server_.maps.restore_revision = [&](const v1::RestoreMapRevisionRequest& request,
                                      v1::RestoreMapRevisionResponse& response) {
    names.push_back(request.name());
    response.mutable_revision()->set_name(std::string(kLab) + "/revisions/5");
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"map", "restore", "Lab@2"}));
  ASSERT_OK(Run({"map", "restore", "Lab@stable"}, false));
  EXPECT_THAT(names, ::testing::ElementsAre("sites/s/maps/l/revisions/2", "sites/s/maps/l/aliases/stable"));
  EXPECT_THAT(printed_, HasSubstr("revisions/5"));
}

TEST_F(MapVersionCommandsTest, ExportsTheRevisionOfAnAlias) {
  std::string name;
  server_.maps.export_map = [&](const v1::ExportMapRequest& request, grpc::ServerWriter<v1::ExportMapResponse>&) {
    name = request.name();
    return grpc::Status(grpc::StatusCode::NOT_FOUND, "enough");
  };
  EXPECT_CODE(Run({"map", "export", "Lab", "--revision", "stable"}), absl::StatusCode::kNotFound);
  EXPECT_EQ(name, "sites/s/maps/l/aliases/stable");
  EXPECT_CODE(Run({"map", "export", "Lab", "--revision", "3"}), absl::StatusCode::kNotFound);
  EXPECT_EQ(name, "sites/s/maps/l/revisions/3");
}

TEST_F(MapVersionCommandsTest, TellsWhatCameAndWent) {
  const std::string picture = directory_.path() / "d.png";
  const std::string outlines = directory_.path() / "d.geojson";
  ASSERT_OK(Run({"map", "diff", "Lab@stable", "@4", "--plot", picture, "--geojson", outlines, "--regions", "5"}));
  EXPECT_EQ(diff_.base(), "sites/s/maps/l/aliases/stable");
  EXPECT_EQ(diff_.revision(), "sites/s/maps/l/revisions/4");
  EXPECT_EQ(diff_.max_regions(), 5);
  EXPECT_TRUE(diff_.with_picture());
  EXPECT_EQ(Content(picture), "png");
  EXPECT_EQ(Content(outlines), "{}");
  const json document = Printed();
  EXPECT_EQ(document["cells"]["free"]["occupied"], 30);
  EXPECT_EQ(document["changed_cells"], 1 + 2 + 3 + 30 + 5 + 6);
  EXPECT_EQ(document["regions"][0]["to_occupied"], 32);
  EXPECT_EQ(document["picture"], picture);
  ASSERT_OK(Run({"map", "diff", "Lab@2", "Lab"}, false));
  EXPECT_EQ(diff_.revision(), "sites/s/maps/l/revisions/4");
  EXPECT_FALSE(diff_.with_picture());
  EXPECT_THAT(printed_, HasSubstr("47 cells of 0.05 m have changed (0.12 m2), in 2 regions"));
  EXPECT_THAT(printed_, HasSubstr("2.00 2.25  2.00 x 0.50  32     32"));
}

TEST_F(MapVersionCommandsTest, TwoFilesAreComparedWithoutAServer) {
  const std::string before = MapFile("before", 5);
  const std::string after = MapFile("after", 25);
  const std::string picture = directory_.path() / "d.png";
  ASSERT_OK(Run({"map", "diff", before, after, "--plot", picture}));
  const json document = Printed();
  EXPECT_EQ(document["resolution_m"], 0.1);
  EXPECT_EQ(document["cells"]["free"]["occupied"], 3);
  EXPECT_EQ(document["cells"]["occupied"]["free"], 3);
  EXPECT_EQ(document["region_count"], 2);
  ASSERT_OK_AND_ASSIGN(const grid::PixelImage image, grid::DecodePng(Content(picture)));
  EXPECT_EQ(image.width, 40);
  EXPECT_EQ(image.height, 30);
  EXPECT_TRUE(server_.calls().empty());
  ASSERT_OK(Run({"map", "diff", before, before}, false));
  EXPECT_THAT(printed_, HasSubstr("0 cells of 0.1 m have changed"));
  EXPECT_CODE(Run({"map", "diff", before, "/none/map.yaml"}), absl::StatusCode::kNotFound);
}

TEST_F(MapVersionCommandsTest, ShowsWhichMapsMovedBetweenTwoOptimisations) {
  server_.graph.list_placed_maps = [](const v1::ListPlacedMapsRequest& request, v1::ListPlacedMapsResponse& response) {
    const auto add = [&](const std::string& id, double x, double yaw) {
      v1::PlacedMap& map = *response.add_placed_maps();
      map.set_map("sites/s/maps/" + id);
      map.mutable_pose_world_map()->mutable_pose()->set_x(x);
      map.mutable_pose_world_map()->mutable_pose()->set_yaw(yaw);
    };
    const bool later = request.graph_version() == 9;
    add("h", 1.0, later ? -3.1 : 3.1);
    add("l", later ? 5.5 : 5.0, 0.0);
    if (later) add("x", 7.0, 0.0);
    return grpc::Status::OK;
  };
  const std::string picture = directory_.path() / "moves.png";
  ASSERT_OK(Run({"graph", "diff", "4", "9", "--plot", picture}));
  const json maps = Printed()["maps"];
  ASSERT_EQ(maps.size(), 3U);
  EXPECT_EQ(maps[0]["display_name"], "Lab") << "the farthest first";
  EXPECT_NEAR(maps[0]["distance_m"].get<double>(), 0.5, 1e-9);
  EXPECT_NEAR(maps[1]["turn_rad"].get<double>(), 2 * M_PI - 6.2, 1e-9) << "the short way round";
  EXPECT_FALSE(maps[2].contains("before"));
  ASSERT_OK(grid::DecodePng(Content(picture)));
  ASSERT_OK(Run({"graph", "diff", "4", "4"}, false));
  EXPECT_THAT(printed_, HasSubstr("0 of 2 maps have another place"));
  EXPECT_THAT(printed_, Not(HasSubstr("MOVED")));
  EXPECT_CODE(Run({"graph", "diff", "4", "9", "--plot", "moves.gif"}), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace enfilade::cli
