// SPDX-License-Identifier: Apache-2.0
#include "perception/plan/read_plan.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/prior/formats/geojson_plan.h"
#include "core/prior/plan/plan_check.h"
#include "core/prior/plan/planar.h"
#include "io/file.h"
#include "perception/plan/plan_picture.h"

namespace enfilade::perception {
namespace {

absl::StatusOr<std::optional<double>> ScaleBy(const std::optional<PlanMeasure>& measure) {
  if (!measure) return std::nullopt;
  const double units = (measure->to - measure->from).norm();
  if (!(units > 0) || !std::isfinite(units) || !(measure->metres > 0) || !std::isfinite(measure->metres)) {
    return InvalidArgument("measure: needs two different points and a positive length, got {} units of {} m", units,
                           measure->metres);
  }
  return measure->metres / units;
}

bool LooksLikeJson(std::string_view bytes) {
  const std::size_t first = bytes.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  return first != std::string_view::npos && bytes[first] == '{';
}

// Twice the area of rooms by their circumference: what is narrower lies within a wall.
double NarrowestRoom(const prior::PlanGraph& plan) {
  double thickest = 0;
  for (const prior::PlanWall& wall : plan.walls) thickest = std::max(thickest, wall.thickness);
  return std::max(thickest, 1e-3 * prior::WallLength(plan) / std::sqrt(static_cast<double>(plan.walls.size())));
}

absl::StatusOr<PlanFile> DecodeAny(std::string_view bytes, std::optional<double> metres_per_unit) {
  PlanFile file;
  if (LooksLikeJson(bytes)) {
    ENFILADE_ASSIGN_OR_RETURN(file.graph, prior::ReadGeoJsonPlan(bytes));
    if (metres_per_unit) file.graph.metres_per_unit = metres_per_unit;
    return file;
  }
  ENFILADE_ASSIGN_OR_RETURN(PicturedPlan pictured, RecognisePlan(bytes, metres_per_unit));
  file.graph = std::move(pictured.graph);
  file.picture = std::move(pictured.picture);
  return file;
}

}  // namespace

absl::StatusOr<PlanFile> DecodePlan(std::string_view bytes, const ReadPlanOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const std::optional<double> metres_per_unit, ScaleBy(options.measure));
  ENFILADE_ASSIGN_OR_RETURN(PlanFile file, DecodeAny(bytes, metres_per_unit));
  ENFILADE_RETURN_IF_ERROR(prior::CheckPlan(file.graph));
  if (file.graph.rooms.empty()) file.graph.rooms = prior::FindRooms(file.graph, NarrowestRoom(file.graph));
  if (!file.graph.metres_per_unit) file.warnings.push_back("the scale is unknown: give a measured distance");
  return file;
}

absl::StatusOr<PlanFile> ReadPlanFile(const std::filesystem::path& path, const ReadPlanOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const std::string bytes, io::ReadFile(path));
  absl::StatusOr<PlanFile> file = DecodePlan(bytes, options);
  if (!file.ok()) return WithContext(file.status(), path.string());
  return file;
}

absl::StatusOr<prior::PlanGraph> ReadPlan(const std::filesystem::path& path, const ReadPlanOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(PlanFile file, ReadPlanFile(path, options));
  return std::move(file.graph);
}

}  // namespace enfilade::perception
