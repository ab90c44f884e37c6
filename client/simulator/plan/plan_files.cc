// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/plan/plan_files.h"

#include <string>
#include <system_error>

#include "client/simulator/plan/campus_plan.h"
#include "client/simulator/plan/plan_drawing.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/prior/formats/building_plan.h"
#include "core/prior/formats/geojson_plan.h"
#include "core/prior/formats/svg_plan.h"
#include "io/file.h"
#include "nlohmann/json.hpp"

namespace enfilade::simulator {
namespace {

nlohmann::json Pair(const Eigen::Vector2d& point) { return {point.x(), point.y()}; }

std::string TruthOf(const DeformedPlan& plan) {
  nlohmann::json truth = {{"mirrored", plan.mirrored},
                          {"corners", nlohmann::json::array()},
                          {"walls", nlohmann::json::array()},
                          {"left_out", nlohmann::json::array()}};
  for (std::size_t i = 0; i < plan.corners.size(); ++i) {
    truth["corners"].push_back({{"sheet_px", Pair(plan.graph.corners[i].point)}, {"campus_m", Pair(plan.corners[i])}});
  }
  for (std::size_t i = 0; i < plan.graph.walls.size(); ++i) {
    const prior::PlanWall& wall = plan.graph.walls[i];
    truth["walls"].push_back({{"from", wall.from}, {"to", wall.to}, {"invented", static_cast<bool>(plan.invented[i])}});
  }
  for (const auto& [from, to] : plan.left_out) truth["left_out"].push_back({Pair(from), Pair(to)});
  return truth.dump(1) + "\n";
}

absl::Status WriteLevel(const Campus& campus, const std::string& level, const PlanDeformation& deformation,
                        const std::filesystem::path& folder) {
  const DeformedPlan plan = Deform(PlanOf(campus, level), deformation);
  if (plan.graph.walls.empty()) return InvalidArgument("level {} has no walls to draw a plan of", level);
  const std::string name = campus.levels.size() == 1 ? "plan" : level;
  const double nominal = 1 / deformation.px_per_m;
  ENFILADE_RETURN_IF_ERROR(io::WriteFile(folder / (name + ".geojson"), prior::WriteGeoJsonPlan(plan.graph)));
  ENFILADE_RETURN_IF_ERROR(io::WriteFile(folder / (name + ".svg"), prior::WriteSvgPlan(plan.graph)));
  ENFILADE_RETURN_IF_ERROR(
      io::WriteFile(folder / (name + ".building.yaml"), prior::WriteBuildingPlan(plan.graph, level, nominal)));
  ENFILADE_ASSIGN_OR_RETURN(const std::string filled, DrawSheet(plan.graph, LineStyle::kFilled));
  ENFILADE_RETURN_IF_ERROR(io::WriteFile(folder / (name + "-filled.png"), filled));
  ENFILADE_ASSIGN_OR_RETURN(const std::string lines, DrawSheet(plan.graph, LineStyle::kDouble));
  ENFILADE_RETURN_IF_ERROR(io::WriteFile(folder / (name + "-double.png"), lines));
  return io::WriteFile(folder / (name + "-truth.json"), TruthOf(plan));
}

}  // namespace

absl::Status WritePlanFiles(const Campus& campus, const PlanDeformation& deformation,
                            const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return FailedPrecondition("{}: {}", folder.string(), error.message());
  for (const auto& [level, height] : campus.levels) {
    ENFILADE_RETURN_IF_ERROR(WriteLevel(campus, level, deformation, folder));
  }
  return absl::OkStatus();
}

}  // namespace enfilade::simulator
