// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

#include "perception/plan/opencv_ink.h"
#include "perception/plan/walls/stroke_graph.h"

namespace enfilade::perception {

// Thins the strokes and the edges of masses and divides them into straight pieces, no farther than about 1.5 px from
// the skeleton (Douglas and Peucker 1973). Stubs shorter than the stroke that they grow from are noise of the skeleton
// and dropped.
StrokeGraph TraceStrokes(const Ink& ink);

}  // namespace enfilade::perception
