// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "perception/plan/stroke_graph.h"

namespace enfilade::perception {

// What draughtsmen draw with the pen of thin walls, of those strokes that `among` has. `diagonal`: of the sheet, px.

// Small arcs and circles, no wider than 6 % of the diagonal: the ways of doors' leaves, columns. With an arc goes a
// leaf: a straight stroke from one of its ends, as long as its radius.
std::vector<bool> FindSwings(const StrokeGraph& drawing, const std::vector<bool>& among, double diagonal);

// Dimensions: lines between two ticks, and the lines that lead from the ticks to what is measured. At a tick, lines
// cross that end a little farther.
std::vector<bool> FindDimensions(const StrokeGraph& drawing, const std::vector<bool>& among, double diagonal);

}  // namespace enfilade::perception
