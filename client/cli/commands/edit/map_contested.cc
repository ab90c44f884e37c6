// SPDX-License-Identifier: Apache-2.0
// `enfilade map contested`.
#include <algorithm>
#include <iostream>
#include <memory>

#include "client/cli/commands/commands.h"
#include "client/cli/commands/edit/draft_output.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/map_edit_service.grpc.pb.h"

namespace enfilade::cli {
namespace {

struct ContestedCommandOptions {
  std::string map;
  std::vector<std::string> keep;
  std::vector<std::string> drop;
  std::string message;
};

// A contested place on the command line. It stays the same while other places come and go.
std::string ContestName(const v1::ContestedEdit& contested) {
  return fmt::format("{}@{},{}", IdOf(contested.session()), contested.box().first_column(),
                     contested.box().first_row());
}

nlohmann::json ContestToJson(const v1::ContestedEdit& contested) {
  return {{"place", ContestName(contested)},
          {"box", BoxToJson(contested.box())},
          {"cells", contested.cells()},
          {"edited", ValueText(contested.edited())},
          {"seen", ValueText(contested.seen())},
          {"session", contested.session()},
          {"edit_version", contested.edit_version()},
          {"authors", std::vector<std::string>(contested.authors().begin(), contested.authors().end())},
          {"message", contested.message()}};
}

std::vector<std::string> ContestToRow(const v1::ContestedEdit& contested) {
  return {ContestName(contested),
          PlaceText(contested.box(), LatticeOf(contested.lattice())),
          std::to_string(contested.cells()),
          ValueText(contested.edited()),
          ValueText(contested.seen()),
          PeopleText(contested.authors()),
          contested.message()};
}

absl::Status AddSettlements(const std::vector<std::string>& names, v1::ContestSettlement::Choice choice,
                            const v1::ListContestedEditsResponse& listed, v1::SettleContestedEditsRequest& request) {
  for (const std::string& name : names) {
    bool is_known = false;
    for (const v1::ContestedEdit& contested : listed.contested()) {
      if (name != "all" && name != ContestName(contested)) continue;
      is_known = true;
      v1::ContestSettlement& settlement = *request.add_settlements();
      *settlement.mutable_box() = contested.box();
      settlement.set_session(contested.session());
      settlement.set_choice(choice);
    }
    if (!is_known) return NotFound("nothing is contested at \"{}\": enfilade map contested lists the places", name);
  }
  return absl::OkStatus();
}

absl::Status SettleContested(const Globals& globals, const client::Connection& connection, const v1::Map& map,
                             const v1::ListContestedEditsResponse& listed, const ContestedCommandOptions& options) {
  v1::SettleContestedEditsRequest request;
  request.set_parent(map.name());
  request.set_message(options.message.empty() ? "Contested edits settled" : options.message);
  ENFILADE_RETURN_IF_ERROR(AddSettlements(options.keep, v1::ContestSettlement::CHOICE_KEEP, listed, request));
  ENFILADE_RETURN_IF_ERROR(AddSettlements(options.drop, v1::ContestSettlement::CHOICE_DROP, listed, request));
  ENFILADE_ASSIGN_OR_RETURN(const auto response,
                            connection.Call(&v1::MapEditService::Stub::SettleContestedEdits, request));
  if (globals.json) {
    PrintJson(std::cout, {{"revision", response.revision().name()}, {"settled", request.settlements_size()}});
  } else {
    std::cout << response.revision().name() << ": " << request.settlements_size() << " contested places settled\n";
  }
  return absl::OkStatus();
}

absl::Status RunContested(const Globals& globals, const ContestedCommandOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const v1::Map map, FindMap(connection, globals, options.map));
  v1::ListContestedEditsRequest request;
  request.set_parent(map.name());
  ENFILADE_ASSIGN_OR_RETURN(const auto listed, connection.Call(&v1::MapEditService::Stub::ListContestedEdits, request));
  if (!options.keep.empty() || !options.drop.empty()) {
    return SettleContested(globals, connection, map, listed, options);
  }
  const std::vector<v1::ContestedEdit> contested(listed.contested().begin(), listed.contested().end());
  PrintList<v1::ContestedEdit>(globals, contested,
                               {"PLACE", "WHERE", "CELLS", "EDITED", "SEEN", "BY", "MESSAGE OF THE EDIT"},
                               ContestToJson, ContestToRow);
  return absl::OkStatus();
}

}  // namespace

void AddMapContested(CLI::App& map, const Globals& globals) {
  const auto options = std::make_shared<ContestedCommandOptions>();
  CLI::App* command =
      AddCommand(map, "contested", "List edits that robots contradict since they were published, or settle them",
                 [&globals, options] { return RunContested(globals, *options); });
  command->add_option("MAP", options->map, "The map's name, id or resource name")->required();
  command->add_option("--keep", options->keep, "Places (SESSION@COLUMN,ROW, or all) where the edit holds");
  command->add_option("--drop", options->drop, "Places where the map shows again what robots see");
  command->add_option("-m,--message", options->message, "Why, at most 500 characters");
  command->footer(
      "Example: enfilade map contested \"Main hall\"\n"
      "         enfilade map contested \"Main hall\" --keep s17@120,-4 --drop s17@180,22");
}

}  // namespace enfilade::cli
