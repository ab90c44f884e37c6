// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/commands/prior/prior_fit_files.h"
#include "client/cli/commands/prior/prior_map_output.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "client/sdk/api/prior_maps.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/prior_map_service.grpc.pb.h"
#include "fmt/format.h"

namespace enfilade::cli {
namespace {

struct PriorAlignOptions {
  std::string plan;
  std::string pairs;
  std::string map;
  bool from_last = false;
  bool activate = false;
  bool dry_run = false;
};

absl::Status AddControlPairs(const client::Connection& connection, const Globals& globals,
                             const PriorAlignOptions& options, v1::AlignPriorMapRequest& request) {
  if (options.pairs.empty()) return absl::OkStatus();
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<prior::ControlPair> pairs, ReadPairs(options.pairs));
  std::string frame;  // empty: the world
  if (!options.map.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(const v1::Map map, FindMap(connection, globals, options.map));
    frame = map.name();
  }
  for (const prior::ControlPair& pair : pairs) {
    v1::ControlPair& sent = *request.add_pairs();
    sent.set_sheet_x(pair.point_sheet.x());
    sent.set_sheet_y(pair.point_sheet.y());
    sent.set_map(frame);
    sent.set_x_m(pair.point_map.x());
    sent.set_y_m(pair.point_map.y());
  }
  return absl::OkStatus();
}

// A plan that was refused keeps its earlier alignment, which says nothing about this one.
void PrintAligned(const Globals& globals, const v1::AlignPriorMapResponse& response) {
  const v1::PriorMap& plan = response.prior_map();
  const bool accepted = plan.state() != v1::PriorMap::STATE_DIVERGED;
  const auto& residuals = response.pair_residuals_m();
  if (globals.json) {
    nlohmann::json document = PriorMapToJson(plan);
    document["accepted"] = accepted;
    document["pair_residuals_m"] = std::vector<double>(residuals.begin(), residuals.end());
    return PrintJson(std::cout, document);
  }
  std::cout << (accepted ? StateText(plan.state()) : "refused") << ": " << plan.reason() << '\n';
  if (accepted) std::cout << AlignmentText(plan.alignment()) << '\n';
  for (int i = 0; i < residuals.size(); ++i) std::cout << fmt::format("pair {}: {:.2f} m\n", i + 1, residuals[i]);
}

absl::Status RunPriorAlign(const Globals& globals, const PriorAlignOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  v1::AlignPriorMapRequest request;
  ENFILADE_RETURN_IF_ERROR(AddControlPairs(connection, globals, options, request));
  ENFILADE_ASSIGN_OR_RETURN(const v1::PriorMap found,
                            client::FindPriorMap(connection, SiteId(globals.site), options.plan));
  request.set_name(found.name());
  request.set_from_last(options.from_last);
  request.set_activate(options.activate);
  request.set_validate_only(options.dry_run);
  ENFILADE_ASSIGN_OR_RETURN(const auto response, connection.Call(&v1::PriorMapService::Stub::AlignPriorMap, request));
  PrintAligned(globals, response);
  return absl::OkStatus();
}

}  // namespace

void AddPriorAlign(CLI::App& prior, const Globals& globals) {
  const auto options = std::make_shared<PriorAlignOptions>();
  CLI::App* command =
      AddCommand(prior, "align", "Find where a plan lies in the maps of its level, and move its walls onto theirs",
                 [&globals, options] { return RunPriorAlign(globals, *options); });
  command->add_option("PLAN", options->plan, "Its name, id or resource name")->required();
  CLI::Option* pairs = command->add_option(
      "--pairs", options->pairs,
      "Points that are known in both: lines of plan_x_px,plan_y_px,x_m,y_m (default: it is found without help)");
  command->add_option("--map", options->map, "The points lie in this map's frame (default: in the world's)")
      ->needs(pairs);
  command
      ->add_flag("--from-last", options->from_last,
                 "Begin where it was placed last, and do not look elsewhere: after `prior edit`, or when robots have "
                 "mapped more")
      ->excludes(pairs);
  command->add_flag("--activate", options->activate, "Use it at once if it is accepted");
  command->add_flag("--dry-run", options->dry_run, "Only say what would become of it");
  command->footer(
      "Examples:\n  enfilade prior align \"Ground floor\"\n"
      "  enfilade prior align \"Ground floor\" --pairs pairs.csv --map Hall --activate\n"
      "  enfilade prior align \"Ground floor\" --from-last");
}

}  // namespace enfilade::cli
