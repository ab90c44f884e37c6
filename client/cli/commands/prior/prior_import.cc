// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <iostream>
#include <memory>
#include <string>

#include "client/cli/commands/commands.h"
#include "client/cli/commands/prior/plan_options.h"
#include "client/cli/commands/prior/plan_overlay.h"
#include "client/cli/output.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/grid/files/png_codec.h"
#include "core/prior/formats/geojson_plan.h"
#include "core/prior/plan/directions.h"
#include "io/file.h"
#include "perception/plan/read_plan.h"

namespace enfilade::cli {
namespace {

struct PriorImportOptions {
  PlanOptions plan;
  std::string output;
  std::string plot;
  std::string sheet;
};

nlohmann::json SummaryOf(const perception::PlanFile& file) {
  const prior::PlanGraph& plan = file.graph;
  nlohmann::json summary = {{"walls", plan.walls.size()},
                            {"corners", plan.corners.size()},
                            {"doors", plan.doors.size()},
                            {"rooms", plan.rooms.size()},
                            {"shafts", plan.shafts.size()},
                            {"wall_length", prior::WallLength(plan)},
                            {"directions_deg", nlohmann::json::array()},
                            {"warnings", file.warnings}};
  for (const double direction : prior::DominantDirections(plan))
    summary["directions_deg"].push_back(direction * 180.0 / M_PI);
  if (plan.metres_per_unit) summary["metres_per_unit"] = *plan.metres_per_unit;
  return summary;
}

void PrintSummary(const Globals& globals, const perception::PlanFile& file) {
  if (globals.json) return PrintJson(std::cout, SummaryOf(file));
  const prior::PlanGraph& plan = file.graph;
  std::cout << fmt::format("{} walls, {} corners, {} doors, {} rooms, {} shafts\n", plan.walls.size(),
                           plan.corners.size(), plan.doors.size(), plan.rooms.size(), plan.shafts.size());
  const double length = prior::WallLength(plan);
  std::cout << (plan.metres_per_unit ? fmt::format("{:.1f} m of walls, {:.5g} m per unit\n",
                                                   length * *plan.metres_per_unit, *plan.metres_per_unit)
                                     : fmt::format("{:.0f} units of walls\n", length));
  for (const std::string& warning : file.warnings) std::cerr << "warning: " << warning << '\n';
}

absl::Status RunPriorImport(const Globals& globals, const PriorImportOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const perception::ReadPlanOptions reading, ToReadOptions(options.plan));
  ENFILADE_ASSIGN_OR_RETURN(const perception::PlanFile file, perception::ReadPlanFile(options.plan.path, reading));
  if (!options.output.empty()) {
    ENFILADE_RETURN_IF_ERROR(io::WriteFile(options.output, prior::WriteGeoJsonPlan(file.graph)));
  }
  if (!options.plot.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(const std::string png, grid::EncodePng(DrawPlan(file.graph, file.picture)));
    ENFILADE_RETURN_IF_ERROR(io::WriteFile(options.plot, png));
  }
  if (!options.sheet.empty()) {
    if (!file.picture) return InvalidArgument("prior import: --sheet needs a picture, {} is none", options.plan.path);
    ENFILADE_ASSIGN_OR_RETURN(const std::string png,
                              grid::EncodePng(grid::PixelImage{.width = file.picture->width,
                                                               .height = file.picture->height,
                                                               .channels = 1,
                                                               .samples = file.picture->pixels}));
    ENFILADE_RETURN_IF_ERROR(io::WriteFile(options.sheet, png));
  }
  PrintSummary(globals, file);
  return absl::OkStatus();
}

}  // namespace

void AddPriorImport(CLI::App& prior, const Globals& globals) {
  auto options = std::make_shared<PriorImportOptions>();
  CLI::App* command = AddCommand(prior, "import", "Read the walls, doors and rooms of a floor plan",
                                 [&globals, options] { return RunPriorImport(globals, *options); });
  AddPlanOptions(*command, options->plan);
  command->add_option("-o,--output", options->output, "Write the plan as GeoJSON (docs/prior_maps.md)");
  command->add_option("--plot", options->plot, "Write a PNG: what was read, over the picture");
  command->add_option("--sheet", options->sheet,
                      "Write a PNG of the picture as it was read: grey, upright, the photo of a page rectified");
  command->footer(
      "Examples:\n  enfilade prior import floor.png -o walls.geojson --plot walls.png\n"
      "  enfilade prior import floor.png --measure 120,40,480,40=7.2 --json\n"
      "  enfilade prior import house.dxf --layers 'A-WALL*' -o walls.geojson");
}

}  // namespace enfilade::cli
