// SPDX-License-Identifier: Apache-2.0
// Floor plans and buildings handled by the tool alone, against a real server.
#include <gmock/gmock.h>

#include <chrono>
#include <fstream>
#include <thread>

#include "core/grid/files/map_files.h"
#include "core/prior/formats/building_plan.h"
#include "core/prior/formats/geojson_plan.h"
#include "fmt/format.h"
#include "nlohmann/json.hpp"
#include "tests/e2e/whole_system.h"
#include "tests/support/command.h"
#include "tests/support/plans/drawn_building.h"
#include "tests/support/status_assertions.h"

namespace enfilade::testing {
namespace {

using nlohmann::json;
using ::testing::EndsWith;
using ::testing::HasSubstr;

class PriorCommands : public ::testing::Test {
 protected:
  PriorCommands() : system_({}) { system_.CreateSite("s"); }

  std::string File(const std::string& name, const std::string& content = "") const {
    const std::string path = (system_.directory() / name).string();
    if (!content.empty()) std::ofstream(path, std::ios::binary) << content;
    return path;
  }
  static grid::OccupancyGrid ReadMap(const std::string& folder, const std::string& name) {
    std::vector<grid::MapFile> files;
    for (const char* extension : {".yaml", ".png"}) {
      std::ifstream in(folder + "/" + name + extension, std::ios::binary);
      files.push_back({name + extension, {std::istreambuf_iterator<char>(in), {}}});
    }
    const auto imported = grid::ImportFiles(files, grid::MapDialect::kNav2);
    EXPECT_OK(imported.status());
    return imported.ok() ? grid::ToOccupancyGrid(imported->raster) : grid::OccupancyGrid();
  }
  // What robots have seen of the drawn building: all but its right end.
  void ImportMap() {
    const auto place = [](const Eigen::Vector2d& sheet) -> Eigen::Vector2d {
      return 0.05 * Eigen::Vector2d(sheet.x(), -sheet.y());
    };
    const auto files = grid::RenderFiles(
        grid::FromOccupancyGrid(
            prior::MapOf(prior::DrawnBuilding(), place, [](const Eigen::Vector2d& sheet) { return sheet.x() < 600; })),
        "seen", {.format = grid::MapFileFormat::kPng});
    ASSERT_OK(files.status());
    for (const grid::MapFile& file : *files) File(file.name, file.bytes);
    Run({"map", "import", File("seen.yaml"), "--map", "Seen"});
  }

  CommandResult Try(const std::vector<std::string>& arguments, const std::string& site = "s") {
    std::vector<std::string> command = {Program("enfilade"),        "--quiet", "--json", "--timeout", "300", "--server",
                                        system_.server().address(), "--site",  site};
    command.insert(command.end(), arguments.begin(), arguments.end());
    return RunCommand(command);
  }
  json Run(const std::vector<std::string>& arguments, const std::string& site = "s") {
    const CommandResult result = Try(arguments, site);
    EXPECT_EQ(result.exit_code, 0) << arguments[0] << ' ' << arguments[1] << ": " << result.output;
    return json::parse(result.output, nullptr, false);
  }

  WholeSystem system_;
};

TEST_F(PriorCommands, APlanningMapIsPublishedAsARevision) {
  ImportMap();
  File("plan.geojson", prior::WriteGeoJsonPlan(prior::DrawnBuilding()));
  Run({"prior", "add", File("plan.geojson"), "--name", "Ground floor"});
  EXPECT_THAT(Try({"prior", "publish", "Ground floor", "--to", "planning"}).output, HasSubstr("not aligned"));
  Run({"prior", "align", "Ground floor", "--activate"});
  Run({"prior", "export", "Ground floor", "-o", File("exported"), "--product", "planning"});
  const grid::OccupancyGrid exported = ReadMap(File("exported"), "planning");

  EXPECT_THAT(Try({"prior", "publish", "Ground floor", "--to", "s"}).output, HasSubstr("own site"));
  EXPECT_NE(Try({"prior", "publish", "Ground floor", "--to", "planning"}).exit_code, 0) << "no such site";
  system_.CreateSite("planning");
  for (int i = 0; i < 2; ++i) {  // what has not changed is no new revision
    const json published = Run({"prior", "publish", "Ground floor", "--to", "planning"});
    EXPECT_THAT(published["revision"].get<std::string>(), EndsWith("/revisions/1"));
  }
  Run({"map", "export", "Ground floor", "-o", File("published"), "--format", "png"}, "planning");
  const grid::OccupancyGrid published = ReadMap(File("published"), "Ground-floor");
  EXPECT_EQ(published.geometry, exported.geometry);
  EXPECT_EQ(published.cells, exported.cells);
  EXPECT_GT(std::count_if(published.cells.begin(), published.cells.end(),
                          [](std::uint8_t cell) { return cell != grid::kUnknownCell; }),
            300'000)
      << "44 m x 24 m, less a corner, seen or not";
  EXPECT_EQ(Run({"map", "list"}).size(), 1u) << "nothing was added to the plan's own site";
}

// The plan is drawn as people draw it, at another scale and with bent walls.
TEST_F(PriorCommands, ARobotIsLocatedInAPlanOfTheSiteAsInItsFile) {
  Run({"simulate", "random:402", "-o", File("campus"), "--plan-out", File("plan"), "--plan-deform", "402"});
  const std::string plan = File("plan/plan.geojson");
  const std::string log = File("campus/robot/log.jsonl");
  std::ifstream truth_file(File("campus/robot/truth.txt"));
  double time = 0;
  Pose2 start;
  truth_file >> time >> start.x >> start.y >> start.yaw;
  std::ifstream corners_file(File("plan/plan-truth.json"));
  const json corners = json::parse(corners_file)["corners"];
  std::string pairs;
  for (const json& corner : {corners.front(), corners.back()}) {
    const Eigen::Vector2d point = Inverse(start) * Eigen::Vector2d(corner["campus_m"][0], corner["campus_m"][1]);
    pairs += fmt::format("{},{},{},{}\n", corner["sheet_px"][0].get<double>(), corner["sheet_px"][1].get<double>(),
                         point.x(), point.y());
  }
  File("pairs.csv", pairs);
  Run({"prior", "add", plan, "--name", "Ground floor"});
  const json in_file = Run({"prior", "locate", plan, log, "--pairs", File("pairs.csv")});
  const json stored = Run({"prior", "locate", "Ground floor", log, "--pairs", File("pairs.csv")});
  EXPECT_EQ(in_file["confident"], true);
  EXPECT_EQ(stored["confident"], true) << stored["reason"];
  const auto place = [](const json& located) {
    const json& mode = located["modes"][0];
    return mode["metres_per_px"].get<double>() *
           Eigen::Vector2d(mode["plan_px"][0].get<double>(), mode["plan_px"][1].get<double>());
  };
  EXPECT_LT((place(in_file) - place(stored)).norm(), 0.5) << in_file["modes"] << stored["modes"];
  EXPECT_LT(std::abs(WrapAngle(in_file["modes"][0]["yaw"].get<double>() - stored["modes"][0]["yaw"].get<double>())),
            0.1);
  EXPECT_THAT(Try({"prior", "locate", "Cellar", log}).output, HasSubstr("is no file; as a plan of sites/s"));
}

TEST_F(PriorCommands, AServerThatIsKilledDuringAnAlignmentLosesNothing) {
  ImportMap();
  File("plan.geojson", prior::WriteGeoJsonPlan(prior::DrawnBuilding()));
  Run({"prior", "add", File("plan.geojson"), "--name", "Ground floor"});
  Run({"prior", "align", "Ground floor"});
  const json before = Run({"prior", "show", "Ground floor"});
  ASSERT_EQ(before["state"], "proposed");
  CommandResult aligned;
  std::thread caller([&] { aligned = Try({"prior", "align", "Ground floor", "--activate"}); });
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  system_.server().Kill();
  system_.server().StartAndWait();
  caller.join();
  const json after = Run({"prior", "show", "Ground floor"});
  EXPECT_TRUE(after == before || (aligned.exit_code == 0 && after["state"] == "active"))
      << aligned.output << before.dump(1) << after.dump(1);
  EXPECT_EQ(Run({"prior", "align", "Ground floor", "--activate"})["accepted"], true);
  EXPECT_EQ(Run({"prior", "show", "Ground floor"})["state"], "active");
}

TEST_F(PriorCommands, AnImportedBuildingIsDrawn) {
  File("house.building.yaml", prior::WriteBuildingPlan(prior::DrawnBuilding(), "L1", 0.05));
  Run({"import", "building", File("house.building.yaml"), "--prefix", "House "});
  Run({"map", "export", "House L1", "-o", File("drawn"), "--format", "png"});
  const grid::OccupancyGrid drawn = ReadMap(File("drawn"), "House-L1");
  EXPECT_EQ(drawn.geometry.resolution, 0.05);
  const auto at = [&](double x, double y) {
    const Eigen::Vector2d cell = Inverse(drawn.geometry.T_map_grid) * Eigen::Vector2d(x, y) / drawn.geometry.resolution;
    return drawn.cells[drawn.geometry.index(static_cast<int>(cell.x()), static_cast<int>(cell.y()))];
  };
  EXPECT_LT(grid::ProbabilityOfCell(at(10.0, -11.25)), 0.2) << "the corridor";
  EXPECT_GT(grid::ProbabilityOfCell(at(20.0, 0.0)), 0.8) << "the outer wall";
  EXPECT_EQ(at(40.0, -20.0), grid::kUnknownCell) << "outside";
}

}  // namespace
}  // namespace enfilade::testing
