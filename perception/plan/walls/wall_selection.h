// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "perception/plan/walls/stroke_graph.h"

namespace enfilade::perception {

struct SelectedStrokes {
  StrokeGraph walls;
  StrokeGraph others;        // text, furniture, doors' leaves
  double thin_pen = 0;       // px: the widest stroke of the pens that draw no walls; 0: there is no such pen
  double thinnest_wall = 0;  // px: the thinnest stroke of the pens that draw walls and are wider than that
};

// Tells walls from what else a plan shows by how it is drawn. Walls are the strokes of the widest pens, and those of a
// thinner pen if most of what it draws are long lines that begin and end at other lines; never what is small and stands
// alone, such as text. All sizes are relative to `diagonal`, that of the sheet in px, and to the pens' widths.
SelectedStrokes SelectWalls(const StrokeGraph& drawing, double diagonal);

}  // namespace enfilade::perception
