// SPDX-License-Identifier: Apache-2.0
// Commands for the plans of a site: what they ask for, and what they print.
#include "tests/unit/client/cli/server_commands_fixture.h"

namespace enfilade::cli {
namespace {

using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

v1::PriorMap GroundFloor() {
  v1::PriorMap plan;
  plan.set_name("sites/s/priorMaps/g");
  plan.set_display_name("Ground floor");
  plan.set_state(v1::PriorMap::STATE_PROPOSED);
  plan.set_reason("it fits");
  plan.set_file_name("floor.png");
  plan.set_etag("e-g");
  plan.mutable_elements()->set_walls(34);
  plan.add_warnings("2 walls are thin");
  v1::PriorAlignment& alignment = *plan.mutable_alignment();
  for (const double value : {0.02, 0.0, 1.0, 0.0, -0.02, 2.0}) alignment.add_affine_world_sheet(value);
  alignment.set_model(v1::PriorAlignment::MODEL_SIMILARITY);
  alignment.set_explained(0.93);
  alignment.set_contradicted(0.02);
  alignment.add_maps("sites/s/maps/h");
  alignment.set_graph_version(7);
  return plan;
}

// The site has one plan, "Ground floor" (sites/s/priorMaps/g).
class PriorMapCommandsTest : public ServerCommandsTest {
 protected:
  PriorMapCommandsTest() {
    server_.prior_maps.list = [](const v1::ListPriorMapsRequest&, v1::ListPriorMapsResponse& response) {
      *response.add_prior_maps() = GroundFloor();
      return grpc::Status::OK;
    };
    server_.prior_maps.get = [](const v1::GetPriorMapRequest&, v1::GetPriorMapResponse&) {
      return grpc::Status(grpc::StatusCode::NOT_FOUND, "no plan");
    };
  }
  absl::Status Run(std::vector<std::string> arguments, bool as_json = true) {
    const auto add = [](CLI::App& app, const Globals& globals) { AddPrior(app, globals); };
    arguments.insert(arguments.begin(), "prior");
    return RunCommandLine(add, std::move(arguments), as_json);
  }
};

TEST_F(PriorMapCommandsTest, BadArgumentsAreRefusedBeforeTheCall) {
  const std::string plan = File("floor.png", "png");
  const std::string pairs = File("pairs.csv", "1,2,3\n");
  for (const auto& arguments : std::vector<std::vector<std::string>>{{},
                                                                     {"add", plan},
                                                                     {"add", plan, "--name", "G", "--measure", "1,2"},
                                                                     {"add", plan, "--name", "G", "--page", "0"},
                                                                     {"show"},
                                                                     {"align"},
                                                                     {"align", "g", "--map", "Hall"},
                                                                     {"align", "g", "--pairs", pairs},
                                                                     {"align", "g", "--pairs", pairs, "--from-last"},
                                                                     {"edit"},
                                                                     {"edit", "g"},
                                                                     {"edit", "g", "--measure", "1,2=3"},
                                                                     {"edit", "g", File("empty.geojson", "")},
                                                                     {"rename", "g"},
                                                                     {"export", "g"},
                                                                     {"export", "g", "-o", "o", "--product", "wall"}}) {
    EXPECT_CODE(Run(arguments), absl::StatusCode::kInvalidArgument) << ::testing::PrintToString(arguments);
  }
  EXPECT_CODE(Run({"add", "/none/floor.png", "--name", "G"}), absl::StatusCode::kNotFound);
  EXPECT_TRUE(server_.calls().empty());
}

TEST_F(PriorMapCommandsTest, AddSendsTheFileAndHowToReadIt) {
  v1::ImportPriorMapManifest manifest;
  std::string bytes;
  server_.prior_maps.import_file = [&](grpc::ServerReader<v1::ImportPriorMapRequest>& reader,
                                       v1::ImportPriorMapResponse& response) {
    v1::ImportPriorMapRequest part;
    reader.Read(&part);
    manifest = part.manifest();
    while (reader.Read(&part)) bytes += part.chunk().data();
    *response.mutable_prior_map() = GroundFloor();
    response.mutable_prior_map()->clear_alignment();
    return grpc::Status::OK;
  };
  const std::string plan = File("house.dxf", "dxf");
  ASSERT_OK(Run({"add", plan, "--name", "Ground floor", "--level", "-1", "--layers", "A,B*", "--plan-level", "L1",
                 "--page", "2", "--measure", "1,2,3,4=7.5"},
                false));
  EXPECT_EQ(bytes, "dxf");
  EXPECT_EQ(manifest.parent(), "sites/s");
  EXPECT_EQ(manifest.display_name(), "Ground floor");
  EXPECT_EQ(manifest.file().name(), "house.dxf");
  EXPECT_EQ(manifest.level(), -1);
  EXPECT_EQ(manifest.page(), 2);
  EXPECT_THAT(manifest.layers(), ElementsAre("A", "B*"));
  EXPECT_EQ(manifest.plan_level(), "L1");
  EXPECT_EQ(manifest.measure().to_y(), 4.0);
  EXPECT_EQ(manifest.measure().length_m(), 7.5);
  EXPECT_EQ(printed_,
            "added \"Ground floor\" (sites/s/priorMaps/g)\n"
            "34 walls, 0 corners, 0 doors, 0 rooms, 0 shafts\n");
  ASSERT_OK(Run({"add", plan, "--name", "Ground floor"}));
  EXPECT_FALSE(manifest.has_measure());
  EXPECT_EQ(Printed()["walls"], 34);
  EXPECT_EQ(Printed()["warnings"], json::array({"2 walls are thin"}));
  EXPECT_FALSE(Printed().contains("alignment"));
}

TEST_F(PriorMapCommandsTest, PlansAreListedAndShown) {
  ASSERT_OK(Run({"list"}, false));
  EXPECT_EQ(printed_,
            "PLAN  NAME          LEVEL  STATE     WALLS  REASON\n"
            "g     Ground floor  0      proposed  34     it fits\n");
  ASSERT_OK(Run({"list"}));
  EXPECT_EQ(Printed()[0]["name"], "sites/s/priorMaps/g");
  ASSERT_OK(Run({"show", "Ground floor"}));
  EXPECT_EQ(Printed()["alignment"]["model"], "similarity");
  ASSERT_OK(Run({"show", "Ground floor"}, false));
  EXPECT_EQ(printed_,
            "Ground floor\n"
            "sites/s/priorMaps/g  level 0, proposed: it fits\n"
            "floor.png: 34 walls, 0 corners, 0 doors, 0 rooms, 0 shafts\n"
            "warning: 2 walls are thin\n"
            "similarity, 0.02 m per unit of the plan; 93 % of the maps' walls explained, 2 % of the plan's known walls "
            "contradicted\n"
            "aligned with h, graph version 7\n");
  EXPECT_STATUS(Run({"show", "Cellar"}), absl::StatusCode::kNotFound, HasSubstr("Cellar"));
}

TEST_F(PriorMapCommandsTest, AlignSendsPairsInAMapsFrameOrInTheWorlds) {
  v1::AlignPriorMapRequest asked;
  server_.prior_maps.align = [&](const v1::AlignPriorMapRequest& request, v1::AlignPriorMapResponse& response) {
    asked = request;
    *response.mutable_prior_map() = GroundFloor();
    for (int i = 0; i < request.pairs_size(); ++i) response.add_pair_residuals_m(0.125 * (i + 1));
    return grpc::Status::OK;
  };
  const std::string pairs = File("pairs.csv", "# clicked\n10,20,1.5,2.5\n30, 40, 3, 4\n");
  ASSERT_OK(Run({"align", "Ground floor", "--pairs", pairs, "--map", "Hall", "--activate", "--dry-run"}, false));
  EXPECT_EQ(asked.name(), "sites/s/priorMaps/g");
  EXPECT_TRUE(asked.activate());
  EXPECT_TRUE(asked.validate_only());
  ASSERT_EQ(asked.pairs_size(), 2);
  EXPECT_EQ(asked.pairs(0).sheet_y(), 20.0);
  EXPECT_EQ(asked.pairs(0).x_m(), 1.5);
  EXPECT_EQ(asked.pairs(1).map(), "sites/s/maps/h");
  EXPECT_THAT(printed_, HasSubstr("proposed: it fits\nsimilarity, "));
  EXPECT_THAT(printed_, HasSubstr("pair 2: 0.25 m\n"));
  ASSERT_OK(Run({"align", "Ground floor", "--pairs", pairs}));
  EXPECT_EQ(asked.pairs(0).map(), "") << "the world";
  EXPECT_EQ(Printed()["accepted"], true);
  EXPECT_EQ(Printed()["pair_residuals_m"], json::array({0.125, 0.25}));
  ASSERT_OK(Run({"align", "Ground floor"}));
  EXPECT_EQ(asked.pairs_size(), 0);
  EXPECT_FALSE(asked.activate());
  EXPECT_FALSE(asked.validate_only());
  EXPECT_FALSE(asked.from_last());
  ASSERT_OK(Run({"align", "Ground floor", "--from-last"}));
  EXPECT_TRUE(asked.from_last());
}

TEST_F(PriorMapCommandsTest, ARefusedPlanIsAnAnswer) {
  server_.prior_maps.align = [](const v1::AlignPriorMapRequest&, v1::AlignPriorMapResponse& response) {
    *response.mutable_prior_map() = GroundFloor();
    response.mutable_prior_map()->set_state(v1::PriorMap::STATE_DIVERGED);
    response.mutable_prior_map()->set_reason("it fits at two places");
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"align", "Ground floor"}, false));
  EXPECT_EQ(printed_, "refused: it fits at two places\n") << "and nothing of the earlier alignment";
  ASSERT_OK(Run({"align", "Ground floor"}));
  EXPECT_EQ(Printed()["accepted"], false);
  EXPECT_EQ(Printed()["state"], "diverged");
}

// A log of a robot that drives straight on from x = 5 m, 0.3 m and 1 s from scan to scan.
std::string DriveLog(int scans) {
  std::string text;
  for (int i = 0; i < scans; ++i) {
    text += "FLASER 181";
    for (int beam = 0; beam < 181; ++beam) text += " 2.50";
    const std::string pose = std::to_string(5 + 0.3 * i) + " 0 0";
    text += " " + pose + " " + pose + " " + std::to_string(i) + " host " + std::to_string(i) + "\n";
  }
  return text;
}

TEST_F(PriorMapCommandsTest, LocateSendsALogOrASessionToTheServerOfAPlan) {
  v1::LocateInPriorMapRequest asked;
  server_.prior_maps.locate = [&](const v1::LocateInPriorMapRequest& request, v1::LocateInPriorMapResponse& response) {
    asked = request;
    response.set_confident(true);
    response.set_confident_after_m(9.5);
    response.set_travelled_m(12);
    response.set_metres_per_unit(0.04);
    response.set_reason("one place has 98 % of the mass");
    v1::PriorMapMode& mode = *response.add_modes();
    mode.set_mass(0.98);
    mode.set_sheet_x(100);
    mode.set_sheet_y(50.5);
    mode.mutable_pose_plan_robot()->set_x(4);
    mode.set_metres_per_unit(0.05);
    mode.set_mirrored(true);
    for (int i = 0; i < 16; ++i) mode.add_covariance(i % 5 == 0 ? 0.02 : 0);
    mode.mutable_pose_world_robot()->mutable_pose()->set_y(-3);
    return grpc::Status::OK;
  };
  const std::string log = File("drive.clf", DriveLog(41));
  const std::string pairs = File("pairs.csv", "10,20,1,2\n");
  ASSERT_OK(Run({"locate", "Ground floor", log, "--pairs", pairs}));
  EXPECT_EQ(asked.name(), "sites/s/priorMaps/g");
  ASSERT_EQ(asked.scans_size(), 41);
  EXPECT_NEAR(asked.scans(40).pose_odom_robot().x(), 17.0, 1e-6);
  ASSERT_EQ(asked.pairs_size(), 1);
  EXPECT_EQ(asked.pairs(0).sheet_y(), 20);
  EXPECT_NEAR(asked.pairs(0).x_m(), 6.0, 1e-6) << "the file's points are in the frame of the first scan";
  EXPECT_NEAR(asked.pairs(0).y_m(), 2.0, 1e-6);
  const json printed = Printed();
  EXPECT_EQ(printed["confident"], true);
  EXPECT_EQ(printed["confident_after_m"], 9.5);
  const json& mode = printed["modes"][0];
  EXPECT_EQ(mode["plan_px"], json::array({100.0, 50.5}));
  EXPECT_EQ(mode["plan_m"], json::array({4.0, 0.0}));
  EXPECT_EQ(mode["scale"], 1.25);
  EXPECT_EQ(mode["mirrored"], true);
  EXPECT_EQ(mode["covariance"].size(), 4U);
  EXPECT_EQ(mode["covariance"][3][3], 0.02);
  EXPECT_EQ(mode["pose_world_robot"]["y"], -3.0);
  ASSERT_OK(Run({"locate", "Ground floor", "--session", "monday"}, false));
  EXPECT_EQ(asked.session(), "sites/s/sessions/monday");
  EXPECT_EQ(asked.scans_size(), 0);
  EXPECT_THAT(printed_, HasSubstr("100.0 50.5"));
  EXPECT_THAT(printed_, HasSubstr("located after 12.0 m: one place has 98 % of the mass"));
}

TEST_F(PriorMapCommandsTest, LocateNamesWhatAPlanOfASiteDoesNotTake) {
  const std::string log = File("drive.clf", DriveLog(3));
  for (const auto& arguments : std::vector<std::vector<std::string>>{{"locate"},
                                                                     {"locate", "Ground floor"},
                                                                     {"locate", "Ground floor", log, "--session", "m"},
                                                                     {"locate", "Ground floor", log, "--model", "ndt"},
                                                                     {"locate", "Ground floor", log, "-o", "o.json"},
                                                                     {"locate", log},
                                                                     {"locate", log, "--session", "monday"}}) {
    EXPECT_CODE(Run(arguments), absl::StatusCode::kInvalidArgument) << ::testing::PrintToString(arguments);
  }
  EXPECT_TRUE(server_.calls().empty());
  EXPECT_STATUS(Run({"locate", "cellar.png", log}), absl::StatusCode::kNotFound,
                HasSubstr("\"cellar.png\" is no file; as a plan of sites/s"));
}

TEST_F(PriorMapCommandsTest, ChangesNameThePlanAndItsEtag) {
  std::vector<std::string> asked;
  const auto answer = [&](const auto& request, auto& response) {
    asked.push_back(request.name() + " " + request.etag());
    *response.mutable_prior_map() = GroundFloor();
    return grpc::Status::OK;
  };
  server_.prior_maps.activate = answer;
  server_.prior_maps.suspend = answer;
  server_.prior_maps.remove = [&](const v1::DeletePriorMapRequest& request, v1::DeletePriorMapResponse&) {
    asked.push_back(request.name() + " " + request.etag() + (request.force() ? " by force" : ""));
    return grpc::Status::OK;
  };
  v1::UpdatePriorMapRequest renamed;
  server_.prior_maps.update = [&](const v1::UpdatePriorMapRequest& request, v1::UpdatePriorMapResponse& response) {
    renamed = request;
    *response.mutable_prior_map() = request.prior_map();
    return grpc::Status::OK;
  };
  ASSERT_OK(Run({"activate", "Ground floor"}, false));
  EXPECT_EQ(printed_, "in use: \"Ground floor\" (sites/s/priorMaps/g)\n");
  ASSERT_OK(Run({"suspend", "Ground floor"}));
  EXPECT_EQ(Printed()["name"], "sites/s/priorMaps/g");
  ASSERT_OK(Run({"delete", "Ground floor"}, false));
  EXPECT_EQ(printed_, "deleted \"Ground floor\" (sites/s/priorMaps/g)\n");
  ASSERT_OK(Run({"delete", "Ground floor", "--force"}));
  EXPECT_THAT(asked, ElementsAre("sites/s/priorMaps/g e-g", "sites/s/priorMaps/g e-g", "sites/s/priorMaps/g e-g",
                                 "sites/s/priorMaps/g e-g by force"));
  ASSERT_OK(Run({"rename", "Ground floor", "Lobby"}, false));
  EXPECT_EQ(renamed.prior_map().etag(), "e-g");
  EXPECT_THAT(renamed.update_mask().paths(), ElementsAre("display_name"));
  EXPECT_EQ(printed_, "renamed: now \"Lobby\" (sites/s/priorMaps/g)\n");
}

TEST_F(PriorMapCommandsTest, EditSendsTheWholePlanAndSaysWhatHasChanged) {
  v1::EditPriorMapRequest asked;
  server_.prior_maps.edit = [&](const v1::EditPriorMapRequest& request, v1::EditPriorMapResponse& response) {
    asked = request;
    *response.mutable_prior_map() = GroundFloor();
    response.mutable_prior_map()->set_state(v1::PriorMap::STATE_NEW);
    response.mutable_prior_map()->set_reason("align it again");
    response.mutable_changes()->set_walls_added(2);
    response.mutable_changes()->set_doors_removed(1);
    response.mutable_changes()->set_scale_changed(request.has_measure());
    return grpc::Status::OK;
  };
  const std::string plan = File("plan.geojson", "{}");
  ASSERT_OK(Run({"edit", "Ground floor", plan}, false));
  EXPECT_EQ(asked.name(), "sites/s/priorMaps/g");
  EXPECT_EQ(asked.plan(), "{}");
  EXPECT_EQ(asked.etag(), "e-g");
  EXPECT_FALSE(asked.has_measure());
  EXPECT_FALSE(asked.validate_only());
  EXPECT_EQ(printed_,
            "corrected \"Ground floor\" (sites/s/priorMaps/g)\n"
            "walls: 2 added, 0 removed, 0 changed; doors: 0 added, 1 removed\n"
            "34 walls, 0 corners, 0 doors, 0 rooms, 0 shafts\n"
            "new: align it again\n");
  ASSERT_OK(Run({"edit", "Ground floor", "--measure", "1,2,3,4=7.5", "--dry-run", "--etag", "older"}));
  EXPECT_EQ(asked.plan(), "");
  EXPECT_EQ(asked.measure().to_x(), 3.0);
  EXPECT_EQ(asked.etag(), "older");
  EXPECT_TRUE(asked.validate_only());
  EXPECT_EQ(Printed()["changes"]["walls_added"], 2);
  EXPECT_EQ(Printed()["changes"]["scale_changed"], true);
  EXPECT_EQ(Printed()["state"], "new");
  EXPECT_CODE(Run({"edit", "Ground floor", "/none/plan.geojson"}), absl::StatusCode::kNotFound);
}

TEST_F(PriorMapCommandsTest, ExportWritesTheProductsThatAreNamed) {
  v1::ExportPriorMapRequest asked;
  server_.prior_maps.export_files = [&](const v1::ExportPriorMapRequest& request,
                                        grpc::ServerWriter<v1::ExportPriorMapResponse>& writer) {
    asked = request;
    v1::ExportPriorMapResponse manifest;
    enfilade::testing::AddToManifest("fit.png", "png", *manifest.mutable_manifest());
    writer.Write(manifest);
    writer.Write(enfilade::testing::ChunkOf<v1::ExportPriorMapResponse>(0, 0, "png"));
    return grpc::Status::OK;
  };
  const std::string out = directory_.path() / "out";
  ASSERT_OK(Run({"export", "Ground floor", "-o", out, "--product", "corrected", "--product", "picture"}));
  EXPECT_EQ(asked.name(), "sites/s/priorMaps/g");
  EXPECT_THAT(asked.products(), ElementsAre(v1::PRIOR_MAP_PRODUCT_CORRECTED, v1::PRIOR_MAP_PRODUCT_PICTURE));
  EXPECT_EQ(Printed()["files"], json::array({out + "/fit.png"}));
  EXPECT_EQ(Content(out + "/fit.png"), "png");
  ASSERT_OK(Run({"export", "Ground floor", "-o", out}, false));
  EXPECT_EQ(asked.products_size(), 0);
  EXPECT_EQ(printed_, out + "/fit.png\n");
}

}  // namespace
}  // namespace enfilade::cli
