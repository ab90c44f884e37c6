// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/e2e/whole_system.h"

namespace enfilade::testing {

// The result of automatically mapping a simulated campus, compared with the truth.
struct CampusResult {
  // One map for each area that was entered, one link point for each door that was passed, no others, each joining what
  // its door joins, and every return recognised. If all doors of the campus were passed, no candidate is left.
  bool exact = false;
  std::string graph;  // a summary; if it is not exact, with what is wrong
  // Verdicts that put a robot into the map of another area, or took its door for another.
  int false_closures = 0;
  double final_error = 0.0;      // m, of the robots' last poses in the world, the largest
  double final_yaw_error = 0.0;  // rad
  int samples = 0;               // poses in the world while the robots drove
  int inside = 0;                // truth within the 95 % ellipse
  double seconds = 0.0;
  std::vector<std::string> verdicts;  // on passages, with their reasons, in the order of their graph versions
};

struct CampusRun {
  std::string campus = "figure1";  // a shipped one
  std::vector<std::string> robots = {"r1"};
  std::uint64_t seed = 1;
};

// Drives the robots through the campus at the same time, each in its own `enfilade robot`, and waits until the server
// has mapped and judged everything. The first robot begins the first map; the others begin in that map, at their own
// starts, as soon as it exists. Throws if a program fails.
CampusResult RunCampus(WholeSystem& system, const CampusRun& run);

}  // namespace enfilade::testing
