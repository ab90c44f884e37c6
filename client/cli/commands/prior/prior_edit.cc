// SPDX-License-Identifier: Apache-2.0
// `enfilade prior edit`.
#include <iostream>
#include <memory>
#include <string>

#include "client/cli/commands/commands.h"
#include "client/cli/commands/prior/plan_options.h"
#include "client/cli/commands/prior/prior_map_output.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "client/sdk/api/prior_maps.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/prior_map_service.grpc.pb.h"
#include "fmt/format.h"
#include "io/file.h"

namespace enfilade::cli {
namespace {

struct PriorEditOptions {
  std::string plan;
  std::string file;
  std::string measure;
  std::string etag;
  bool dry_run = false;
};

nlohmann::json ChangesToJson(const v1::PriorMapChanges& changes) {
  return {{"walls_added", changes.walls_added()},     {"walls_removed", changes.walls_removed()},
          {"walls_changed", changes.walls_changed()}, {"doors_added", changes.doors_added()},
          {"doors_removed", changes.doors_removed()}, {"scale_changed", changes.scale_changed()}};
}

void PrintEdited(const Globals& globals, const PriorEditOptions& options, const v1::EditPriorMapResponse& response) {
  for (const std::string& warning : response.warnings()) std::cerr << "warning: " << warning << '\n';
  const v1::PriorMap& plan = response.prior_map();
  const v1::PriorMapChanges& changes = response.changes();
  if (globals.json) {
    nlohmann::json document = PriorMapToJson(plan);
    document["changes"] = ChangesToJson(changes);
    return PrintJson(std::cout, document);
  }
  PrintPriorMap(globals, options.dry_run ? "would be corrected:" : "corrected", plan);
  std::cout << fmt::format("walls: {} added, {} removed, {} changed; doors: {} added, {} removed{}\n",
                           changes.walls_added(), changes.walls_removed(), changes.walls_changed(),
                           changes.doors_added(), changes.doors_removed(),
                           changes.scale_changed() ? "; another scale" : "")
            << ElementsText(plan.elements()) << '\n'
            << StateText(plan.state()) << ": " << plan.reason() << '\n';
}

absl::Status RunPriorEdit(const Globals& globals, const PriorEditOptions& options) {
  v1::EditPriorMapRequest request;
  if (options.file.empty() && options.measure.empty()) return InvalidArgument("expected FILE, --measure, or both");
  if (!options.file.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(*request.mutable_plan(), io::ReadFile(options.file));
    if (request.plan().empty()) return InvalidArgument("{} is empty", options.file);
  }
  if (!options.measure.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(const perception::PlanMeasure measure, ParseMeasure(options.measure));
    *request.mutable_measure() = MeasureToProto(measure);
  }
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const v1::PriorMap found,
                            client::FindPriorMap(connection, SiteId(globals.site), options.plan));
  request.set_name(found.name());
  request.set_etag(options.etag.empty() ? found.etag() : options.etag);
  request.set_validate_only(options.dry_run);
  ENFILADE_ASSIGN_OR_RETURN(const auto response, connection.Call(&v1::PriorMapService::Stub::EditPriorMap, request));
  PrintEdited(globals, options, response);
  return absl::OkStatus();
}

}  // namespace

void AddPriorEdit(CLI::App& prior, const Globals& globals) {
  const auto options = std::make_shared<PriorEditOptions>();
  CLI::App* command = AddCommand(prior, "edit", "Correct a plan's walls, doors and scale",
                                 [&globals, options] { return RunPriorEdit(globals, *options); });
  command->add_option("PLAN", options->plan, "Its name, id or resource name")->required();
  command->add_option("FILE", options->file, "The whole plan as it is to be: plan.geojson of the export, changed");
  command->add_option("--measure", options->measure,
                      "A known distance between two points of the plan, X1,Y1,X2,Y2=METRES: gives the scale");
  command->add_option("--etag", options->etag,
                      "Of `prior show --json` when it was exported: fails if somebody has changed it since");
  command->add_flag("--dry-run", options->dry_run, "Only say what would become of it");
  command->footer(
      "Examples:\n  enfilade prior export \"Ground floor\" -o ground --product plan\n"
      "  enfilade prior edit \"Ground floor\" ground/plan.geojson\n"
      "  enfilade prior edit \"Ground floor\" --measure 120,40,480,40=7.2\n"
      "  enfilade prior align \"Ground floor\" --from-last");
}

}  // namespace enfilade::cli
