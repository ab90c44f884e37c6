// SPDX-License-Identifier: Apache-2.0
#include "tests/e2e/campus/kept_files.h"

#include <fstream>
#include <iostream>
#include <map>
#include <system_error>

#include "client/simulator/plan/plan_picture.h"
#include "client/simulator/simulation.h"

namespace enfilade::testing {

namespace fs = std::filesystem;

void KeepSite(const WholeSystem& system, const std::string& site, const std::vector<std::string>& robots,
              const fs::path& folder) {
  std::error_code ignored;
  fs::create_directories(folder, ignored);
  std::vector<std::vector<std::string>> commands = {
      {"graph", "export", "-o", (folder / "graph.geojson").string()},
      {"graph", "plot", "-o", (folder / "graph.svg").string()},
      {"graph", "plot", "-o", (folder / "graph.png").string()},
  };
  for (const std::string& robot : robots) {
    commands.push_back(
        {"trajectory", "export", "--robot", robot, "--world", "-o", (folder / (robot + ".world.txt")).string()});
  }
  for (const std::vector<std::string>& command : commands) {
    try {
      system.Tool(site, command);
    } catch (const std::exception& error) {
      std::cerr << site << ": " << error.what() << '\n';
    }
  }
}

void KeepPlans(const simulator::World& world, const std::vector<DriveTruth>& truths, const fs::path& folder) {
  std::map<std::string, simulator::GroundTruth> drives;
  for (const DriveTruth& truth : truths) {
    simulator::GroundTruth& drive = drives[truth.robot];
    for (const TruePoint& point : truth.poses) {
      drive.poses.push_back({point.time, point.T_campus_robot, point.level, point.area});
    }
    for (const PassedDoor& passage : truth.passages) {
      simulator::TruePassage passed;
      passed.time = passage.time;
      passed.T_campus_robot = passage.T_campus_robot;
      passed.level = passage.level;
      passed.door = passage.door;
      drive.passages.push_back(passed);
    }
  }
  for (const auto& [level, height] : world.campus().levels) {
    const auto png = simulator::DrawPlan(world, level, drives);
    if (png.ok()) std::ofstream(folder / ("truth-" + level + ".png"), std::ios::binary) << *png;
  }
}

void KeepFile(const fs::path& from, const fs::path& to) {
  std::error_code failed;
  fs::copy_file(from, to, fs::copy_options::overwrite_existing, failed);
  if (failed) std::cerr << to.string() << ": " << failed.message() << '\n';
}

}  // namespace enfilade::testing
