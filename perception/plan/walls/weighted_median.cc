// SPDX-License-Identifier: Apache-2.0
#include "perception/plan/walls/weighted_median.h"

#include <algorithm>

namespace enfilade::perception {

double WeightedMedian(std::vector<std::pair<double, double>> values) {
  double total = 0;
  for (const auto& [value, weight] : values) total += weight;
  std::sort(values.begin(), values.end());
  double below = 0;
  for (const auto& [value, weight] : values) {
    below += weight;
    if (below >= total / 2) return value;
  }
  return 0;
}

}  // namespace enfilade::perception
