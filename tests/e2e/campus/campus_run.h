// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tests/e2e/campus/comparison.h"
#include "tests/e2e/campus/consistency.h"
#include "tests/e2e/whole_system.h"

namespace enfilade::testing {

// When a robot starts after the one before it.
enum class Start { kTogether, kDelayed, kAfterwards };

struct CampusRun {
  std::string campus = "figure1";   // a shipped one, random:SEED, suites:SEED, halls:SEED, or a file
  std::vector<std::string> robots;  // empty: the campus's first
  std::uint64_t seed = 1;           // of all noise
  int laps = 0;                     // rounds of each robot's route; 0: the campus's
  Start start = Start::kTogether;
  double delay_s = 0.0;  // kDelayed
  // The first robot begins the first map. The others begin in that map, at their own starts; if this is set, they do
  // not know where they are and begin maps of their own.
  bool unknown_starts = false;
  std::optional<double> image_hz;  // instead of the robot's
  std::optional<double> cloud_hz;
  std::optional<double> field_of_view_deg;  // of the scanner
  std::filesystem::path keep;               // a folder for what is worth looking at; empty: nothing is kept
};

// The result of automatically mapping a simulated campus, compared with the truth.
struct CampusResult {
  std::string site;
  std::vector<std::string> robots;
  Comparison comparison;
  bool has_last_poses = true;    // of all robots, in the world
  double final_error = 0.0;      // m, of these poses, the largest
  double final_yaw_error = 0.0;  // rad
  Consistency poses;             // in the world, while the robots drove
  GraphConsistency graph;        // when everything was done
  double seconds = 0.0;
  std::vector<std::string> verdicts;  // on door reports, with their reasons, robot by robot
};

// Drives the robots through the campus, each in its own `enfilade robot`, and waits until the server has mapped and
// judged everything. Throws if a program fails.
CampusResult RunCampus(WholeSystem& system, const CampusRun& run);

// A campus's name for people: of a file its name without its ending.
std::string CampusNameOf(const std::string& campus);

// A site's id made of any text: small letters, digits and hyphens, at most 63.
std::string SiteIdOf(const std::string& text);

}  // namespace enfilade::testing
