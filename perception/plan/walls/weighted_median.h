// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>
#include <vector>

namespace enfilade::perception {

// Of values (first) with weights (second): the least that half of the weight is at or below. 0 if there are none.
double WeightedMedian(std::vector<std::pair<double, double>> values);

}  // namespace enfilade::perception
