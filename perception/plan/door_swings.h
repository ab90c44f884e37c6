// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "perception/plan/stroke_graph.h"

namespace enfilade::perception {

// Of those strokes that `among` has: small arcs and circles, no wider than 6 % of the sheet's diagonal (px), as the
// ways of doors' leaves and columns are. With an arc goes a leaf: a straight stroke from one of its ends, as long as
// its radius.
std::vector<bool> FindSwings(const StrokeGraph& drawing, const std::vector<bool>& among, double diagonal);

}  // namespace enfilade::perception
