// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/prior/plan_options.h"

#include <cstdio>

#include "core/base/error.h"
#include "core/base/status_macros.h"

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
  ENFILADE_ASSIGN_OR_RETURN(reading.measure, ParseMeasure(options.measure));
  return reading;
}

absl::StatusOr<perception::PlanMeasure> ParseMeasure(const std::string& text) {
  perception::PlanMeasure measure;
  int used = 0;
  if (std::sscanf(text.c_str(), "%lf,%lf,%lf,%lf=%lf%n", &measure.from.x(), &measure.from.y(), &measure.to.x(),
                  &measure.to.y(), &measure.metres, &used) != 5 ||
      used != static_cast<int>(text.size())) {
    return InvalidArgument("--measure \"{}\": expected X1,Y1,X2,Y2=METRES", text);
  }
  return measure;
}

v1::PlanMeasure MeasureToProto(const perception::PlanMeasure& measure) {
  v1::PlanMeasure out;
  out.set_from_x(measure.from.x());
  out.set_from_y(measure.from.y());
  out.set_to_x(measure.to.x());
  out.set_to_y(measure.to.y());
  out.set_length_m(measure.metres);
  return out;
}

}  // namespace enfilade::cli
