// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/prior/plan_options.h"

#include <cstdio>

#include "core/base/error.h"

namespace enfilade::cli {

void AddPlanOptions(CLI::App& command, PlanOptions& options, const std::string& level_option) {
  command.add_option("PLAN", options.path, "The plan (docs/prior_maps.md lists the formats)")->required();
  command.add_option("--measure", options.measure,
                     "A known distance between two points of the plan, X1,Y1,X2,Y2=METRES: gives the scale");
  command.add_option("--page", options.page, "The page of a PDF, from 1")->check(CLI::PositiveNumber);
  command
      .add_option("--layers", options.layers,
                  "Layers of SVG and DXF to read: patterns such as A-WALL*, with commas between them")
      ->delimiter(',');
  command.add_option(level_option, options.level, "The level of a building.yaml (default: the lowest)");
}

absl::StatusOr<perception::ReadPlanOptions> ToReadOptions(const PlanOptions& options) {
  perception::ReadPlanOptions reading{.page = options.page, .layers = options.layers, .level = options.level};
  if (options.measure.empty()) return reading;
  perception::PlanMeasure measure;
  int used = 0;
  if (std::sscanf(options.measure.c_str(), "%lf,%lf,%lf,%lf=%lf%n", &measure.from.x(), &measure.from.y(),
                  &measure.to.x(), &measure.to.y(), &measure.metres, &used) != 5 ||
      used != static_cast<int>(options.measure.size())) {
    return InvalidArgument("--measure \"{}\": expected X1,Y1,X2,Y2=METRES", options.measure);
  }
  reading.measure = measure;
  return reading;
}

}  // namespace enfilade::cli
