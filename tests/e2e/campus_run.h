// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/e2e/whole_system.h"

namespace enfilade::testing {

// What automatic mapping of a simulated campus came to, against the truth.
struct CampusResult {
  // One map for each area that was entered, one link point for each door that was passed, no others, each joining what
  // its door joins, and every return recognised. Where all doors of the campus were passed no candidate is left.
  bool exact = false;
  std::string graph;  // what there is, in words; where it is not exact, what is wrong with it
  // Verdicts that put a robot into the map of an area where it was not, or took its door for another.
  int false_closures = 0;
  double final_error = 0.0;      // m, of the robots' last poses in the world, the largest
  double final_yaw_error = 0.0;  // rad
  int samples = 0;               // of poses in the world while the robots drove
  int inside = 0;                // truth within the 95 % ellipse
  double seconds = 0.0;
  std::vector<std::string> verdicts;  // on passages, with their reasons, in the order in which they were made
};

struct CampusRun {
  std::string campus = "figure1";  // of those that the simulator has
  std::vector<std::string> robots = {"r1"};
  std::uint64_t seed = 1;
};

// Drives the robots through the campus, each an `enfilade robot` of its own, all from the same moment on, and waits
// until the server has mapped and judged all. The first robot begins the first map; the others begin in it, where they
// stand, as soon as it is there. Throws where a program fails.
CampusResult RunCampus(WholeSystem& system, const CampusRun& run);

}  // namespace enfilade::testing
