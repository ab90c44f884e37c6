#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/e2e/whole_system.h"

namespace enfilade::testing {

// What automatic mapping of the campus "figure1" came to, against the truth.
struct Figure1Result {
  bool exact = false;  // 4 maps, 5 link points that stand for the 5 doors, no candidate left, every return recognised
  std::string graph;   // what there is, in words; where it is not exact, what is wrong with it
  int false_closures = 0;        // verdicts that put a robot into a map where it was not
  double final_error = 0.0;      // m, of the robots' last poses in the world, the largest
  double final_yaw_error = 0.0;  // rad
  int samples = 0;               // of poses in the world while the robots drove
  int inside = 0;                // truth within the 95 % ellipse
  double seconds = 0.0;
};

// Drives `robots` (of r1, r2) through the campus with that seed, each an `enfilade robot` of its own, and waits until
// the server has mapped and judged all. The first robot begins the first map; the others begin in it, where they stand,
// when the first one's candidates are known.
// Throws where a program fails.
Figure1Result RunFigure1(WholeSystem& system, std::uint64_t seed, const std::vector<std::string>& robots);

}  // namespace enfilade::testing
