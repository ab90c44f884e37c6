// SPDX-License-Identifier: Apache-2.0
#include "perception/plan/plan_picture.h"

#include <Eigen/Core>
#include <cmath>

#include "core/base/status_macros.h"
#include "perception/image/opencv_guard.h"
#include "perception/plan/opencv_ink.h"
#include "perception/plan/opencv_sheet.h"
#include "perception/plan/opencv_tracing.h"
#include "perception/plan/walls/wall_doors.h"
#include "perception/plan/walls/wall_lines.h"
#include "perception/plan/walls/wall_selection.h"

namespace enfilade::perception {

namespace {

Eigen::Matrix3d ToEigen(const cv::Matx33d& matrix) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(matrix.val);
}

}  // namespace

absl::StatusOr<PicturedPlan> RecognisePlan(std::string_view bytes, const std::optional<PlanMeasure>& measure) {
  ENFILADE_ASSIGN_OR_RETURN(Sheet sheet, DecodeSheet(bytes));
  return GuardOpenCv("recognising walls", [&]() -> absl::StatusOr<PicturedPlan> {
    const std::optional<Page> page = FindPage(sheet.brightness);
    if (page) sheet = Rectify(sheet, *page);
    const double diagonal = std::hypot(sheet.brightness.cols, sheet.brightness.rows);
    Ink ink = FindInk(sheet);
    EraseDashedLines(ink);
    FillDoubleLines(ink);
    SelectedStrokes selected = SelectWalls(TraceStrokes(ink), diagonal);
    if (selected.thinnest_wall > 0 && selected.thin_pen > 0) {
      // Thin strokes that touch walls bend their skeletons: once more without them.
      ink.strokes = WidePartsOf(ink.strokes, std::sqrt(selected.thin_pen * selected.thinnest_wall) / 2);
      selected = SelectWalls(TraceStrokes(ink), diagonal);
    }
    PicturedPlan plan{AssembleWalls(selected.walls), {}};
    if (page) plan.graph.H_sheet_photo = ToEigen(page->H_page_photo);
    if (measure) plan.graph.metres_per_unit = MetresPerUnit(*measure, plan.graph);
    plan.graph.doors = FindDoors(plan.graph, diagonal);
    const cv::Mat whole = sheet.brightness.isContinuous() ? sheet.brightness : sheet.brightness.clone();
    plan.picture = {whole.cols, whole.rows, {whole.data, whole.data + whole.total()}};
    return plan;
  });
}

}  // namespace enfilade::perception
