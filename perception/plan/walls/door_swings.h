// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "perception/plan/walls/stroke_graph.h"

namespace enfilade::perception {

// Of those strokes that `among` has: arcs, as the ways of doors' leaves are, and small circles, as columns are. Their
// radii are at most 3 % and 1.2 % of the sheet's diagonal (px). With an arc goes a leaf: a straight stroke from one of
// its ends, as long as its radius.
std::vector<bool> FindSwings(const StrokeGraph& drawing, const std::vector<bool>& among, double diagonal);

}  // namespace enfilade::perception
