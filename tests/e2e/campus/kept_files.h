// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "client/simulator/world/world.h"
#include "tests/e2e/campus/drive_truth.h"
#include "tests/e2e/whole_system.h"

namespace enfilade::testing {

// What is worth looking at after a run, in `folder` (made if missing). Errors are printed and do not end the run.

// graph.geojson, graph.svg, graph.png, and ROBOT.world.txt: each robot's way in the world.
void KeepSite(const WholeSystem& system, const std::string& site, const std::vector<std::string>& robots,
              const std::filesystem::path& folder);

// truth-LEVEL.png: the campus with the robots' true ways.
void KeepPlans(const simulator::World& world, const std::vector<DriveTruth>& truths,
               const std::filesystem::path& folder);

void KeepFile(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace enfilade::testing
