// SPDX-License-Identifier: Apache-2.0
#include "perception/plan/walls/wall_directions.h"

#include <algorithm>
#include <cmath>

#include "core/prior/plan/directions.h"

namespace enfilade::perception {

void SnapLine(const std::vector<double>& dominant, const Moments& moments, FittedLine& line) {
  const Eigen::Vector2d mean = moments.sum / std::max(moments.count, 1.0);
  const double angle = prior::AngleOfLine(line.Direction());
  for (const double direction : dominant) {
    const double turn = prior::TurnOfLine(angle, direction);
    constexpr double kLargestShift = 0.7;  // px, at the line's ends
    if (std::abs(turn) > prior::kDirectionReach || std::abs(turn) * moments.count / 2 > kLargestShift) continue;
    line.normal = {-std::sin(direction), std::cos(direction)};
    line.offset = line.normal.dot(mean);
    return;
  }
}

}  // namespace enfilade::perception
