// SPDX-License-Identifier: Apache-2.0
#include "perception/plan/plan_picture.h"

#include <cmath>

#include "core/base/status_macros.h"
#include "perception/image/opencv_guard.h"
#include "perception/plan/opencv_ink.h"
#include "perception/plan/opencv_sheet.h"
#include "perception/plan/opencv_tracing.h"
#include "perception/plan/wall_doors.h"
#include "perception/plan/wall_lines.h"
#include "perception/plan/wall_selection.h"

namespace enfilade::perception {

absl::StatusOr<PicturedPlan> RecognisePlan(std::string_view bytes, std::optional<double> metres_per_unit) {
  ENFILADE_ASSIGN_OR_RETURN(const Sheet sheet, DecodeSheet(bytes));
  return GuardOpenCv("recognising walls", [&]() -> absl::StatusOr<PicturedPlan> {
    const double diagonal = std::hypot(sheet.brightness.cols, sheet.brightness.rows);
    Ink ink = FindInk(sheet);
    FillDoubleLines(ink);
    SelectedStrokes selected = SelectWalls(TraceStrokes(ink), diagonal);
    if (selected.thinnest_wall > 0 && selected.thin_pen > 0) {
      // Thin strokes that touch walls bend their skeletons: once more without them.
      ink.strokes = WidePartsOf(ink.strokes, std::sqrt(selected.thin_pen * selected.thinnest_wall) / 2);
      selected = SelectWalls(TraceStrokes(ink), diagonal);
    }
    PicturedPlan plan{AssembleWalls(selected.walls), {}};
    plan.graph.metres_per_unit = metres_per_unit;
    plan.graph.doors = FindDoors(plan.graph, diagonal);
    const cv::Mat whole = sheet.brightness.isContinuous() ? sheet.brightness : sheet.brightness.clone();
    plan.picture = {whole.cols, whole.rows, {whole.data, whole.data + whole.total()}};
    return plan;
  });
}

}  // namespace enfilade::perception
