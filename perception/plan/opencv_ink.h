// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

#include "perception/plan/opencv_sheet.h"

namespace enfilade::perception {

// What is drawn on a sheet. All masks are 8-bit, 0 or 255.
struct Ink {
  cv::Mat strokes;  // drawn lines and filled walls; what is between them is free
  cv::Mat mass;     // solid or unknown: its edge is the face of a wall. Apart from strokes
};

// Removes shading, finds out whether lines are darker or lighter than the paper, drops inks of a colour that is not
// that of most lines, and reads a grey that fills a large part of the sheet evenly (the unknown around and within the
// walls of occupancy maps) as mass where it is wide and as stroke where it is narrow.
Ink FindInk(const Sheet& sheet);

// Fills walls that are drawn as two parallel lines. The gap between the lines has the same width along much of the
// drawing; if less than half of all lines run beside such a gap, nothing is filled.
void FillDoubleLines(Ink& ink);

// Takes dashed and dash-dotted lines away, which bound plots and show what is overhead: five and more bars and dots in
// a row, with gaps that are alike. If most of what is as wide as the widest of them is dashed, the rest of that goes,
// too.
void EraseDashedLines(Ink& ink);

// The parts of a mask that a disk of this radius (px) fits into: its morphological opening.
cv::Mat WidePartsOf(const cv::Mat& mask, double radius);

}  // namespace enfilade::perception
