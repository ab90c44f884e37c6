// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "perception/plan/walls/stroke_graph.h"

namespace enfilade::perception {

// Turns the line about its middle into a dominant direction within 2 degrees, if its points then stay where they are
// to 0.7 px.
void SnapLine(const std::vector<double>& dominant, const Moments& moments, FittedLine& line);

}  // namespace enfilade::perception
