// SPDX-License-Identifier: Apache-2.0
#include "core/grid/occupancy_grid.h"

#include <algorithm>
#include <cmath>

namespace enfilade::grid {

std::uint8_t CellFromProbability(double probability) {
  return static_cast<std::uint8_t>(1 + std::lround(std::clamp(probability, 0.0, 1.0) * 254.0));
}

double ProbabilityOfCell(std::uint8_t cell) { return (static_cast<double>(cell) - 1.0) / 254.0; }

}  // namespace enfilade::grid
