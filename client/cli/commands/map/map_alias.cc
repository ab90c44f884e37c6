// SPDX-License-Identifier: Apache-2.0
// `enfilade map alias` and `enfilade map restore`.
#include <algorithm>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/map_revision.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/map_service.grpc.pb.h"

namespace enfilade::cli {
namespace {

struct MapAliasCommandOptions {
  std::string map;
  std::string alias;
  std::string revision;
  std::string etag;
};

nlohmann::json ToJson(const v1::MapAlias& alias) {
  return {{"name", alias.name()},   {"revision", alias.revision()}, {"previous_revision", alias.previous_revision()},
          {"actor", alias.actor()}, {"etag", alias.etag()},         {"update_time", FormatTime(alias.update_time())}};
}

std::vector<std::string> ToRow(const v1::MapAlias& alias) {
  return {IdOf(alias.name()), IdOf(alias.revision()), IdOf(alias.previous_revision()),
          alias.actor().empty() ? "-" : alias.actor(), FormatTime(alias.update_time())};
}

void PrintAlias(const Globals& globals, const v1::MapAlias& alias) {
  if (globals.json) return PrintJson(std::cout, ToJson(alias));
  std::cout << IdOf(alias.name()) << " leads to " << alias.revision();
  if (!alias.previous_revision().empty()) std::cout << ", before to revision " << IdOf(alias.previous_revision());
  std::cout << '\n';
}

absl::StatusOr<std::vector<v1::MapAlias>> ReadAliases(const client::Connection& connection, const std::string& map) {
  v1::ListMapAliasesRequest request;
  request.set_parent(map);
  ENFILADE_ASSIGN_OR_RETURN(const auto response, connection.Call(&v1::MapService::Stub::ListMapAliases, request));
  return std::vector<v1::MapAlias>(response.aliases().begin(), response.aliases().end());
}

// The revision that a number, an alias or nothing (the newest) means.
absl::StatusOr<std::string> RevisionToName(const client::Connection& connection, const v1::Map& map,
                                           const std::string& revision) {
  ENFILADE_ASSIGN_OR_RETURN(std::string name, RevisionNameOf(map, revision));
  if (name.find("/aliases/") == std::string::npos) return name;
  v1::GetMapRevisionRequest request;
  request.set_name(name);
  ENFILADE_ASSIGN_OR_RETURN(const auto response, connection.Call(&v1::MapService::Stub::GetMapRevision, request));
  return response.revision().name();
}

// Under the etag that the alias has now, so that two people who move it at once notice each other.
absl::Status SetAlias(const Globals& globals, const MapAliasCommandOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const v1::Map map, FindMap(connection, globals, options.map));
  v1::SetMapAliasRequest request;
  v1::MapAlias& alias = *request.mutable_alias();
  alias.set_name(map.name() + "/aliases/" + options.alias);
  alias.set_etag(options.etag);
  if (options.etag.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(const std::vector<v1::MapAlias> present, ReadAliases(connection, map.name()));
    for (const v1::MapAlias& known : present) {
      if (known.name() == alias.name()) alias.set_etag(known.etag());
    }
  }
  ENFILADE_ASSIGN_OR_RETURN(*alias.mutable_revision(), RevisionToName(connection, map, options.revision));
  ENFILADE_ASSIGN_OR_RETURN(const auto response, connection.Call(&v1::MapService::Stub::SetMapAlias, request));
  PrintAlias(globals, response.alias());
  return absl::OkStatus();
}

absl::Status ListAliases(const Globals& globals, const std::string& name) {
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const v1::Map map, FindMap(connection, globals, name));
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<v1::MapAlias> aliases, ReadAliases(connection, map.name()));
  PrintList<v1::MapAlias>(globals, aliases, {"ALIAS", "REVISION", "BEFORE", "WHO", "MOVED (UTC)"}, ToJson, ToRow);
  return absl::OkStatus();
}

absl::Status RollBackAlias(const Globals& globals, const MapAliasCommandOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const v1::Map map, FindMap(connection, globals, options.map));
  v1::RollBackMapAliasRequest request;
  request.set_name(map.name() + "/aliases/" + options.alias);
  request.set_etag(options.etag);
  ENFILADE_ASSIGN_OR_RETURN(const auto response, connection.Call(&v1::MapService::Stub::RollBackMapAlias, request));
  PrintAlias(globals, response.alias());
  return absl::OkStatus();
}

absl::Status DeleteAlias(const Globals& globals, const MapAliasCommandOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const v1::Map map, FindMap(connection, globals, options.map));
  v1::DeleteMapAliasRequest request;
  request.set_name(map.name() + "/aliases/" + options.alias);
  request.set_etag(options.etag);
  ENFILADE_RETURN_IF_ERROR(connection.Call(&v1::MapService::Stub::DeleteMapAlias, request).status());
  if (globals.json) {
    PrintJson(std::cout, {{"deleted", request.name()}});
  } else {
    std::cout << "deleted " << request.name() << '\n';
  }
  return absl::OkStatus();
}

absl::Status RestoreRevision(const Globals& globals, const std::string& revision) {
  if (revision.find('@') == std::string::npos && revision.find("/revisions/") == std::string::npos &&
      revision.find("/aliases/") == std::string::npos) {
    return InvalidArgument("\"{}\": expected MAP@REVISION or MAP@ALIAS: the newest revision needs no restoring",
                           revision);
  }
  const client::Connection connection = ConnectionOf(globals);
  v1::RestoreMapRevisionRequest request;
  ENFILADE_ASSIGN_OR_RETURN(*request.mutable_name(), FindRevision(connection, globals, revision));
  ENFILADE_ASSIGN_OR_RETURN(const auto response, connection.Call(&v1::MapService::Stub::RestoreMapRevision, request));
  if (globals.json) {
    PrintJson(std::cout, {{"revision", response.revision().name()}, {"restored", request.name()}});
  } else {
    std::cout << response.revision().name() << " is " << request.name() << " again\n";
  }
  return absl::OkStatus();
}

void AddAliasOptions(CLI::App& command, const std::shared_ptr<MapAliasCommandOptions>& options) {
  command.add_option("MAP", options->map, "Its name, id or resource name")->required();
  command.add_option("ALIAS", options->alias, "Such as stable: 1 to 63 of a-z, 0-9 and \"-\"")->required();
  command.add_option("--etag", options->etag, "Only if the alias still has this etag (see list --json)");
}

}  // namespace

void AddMapAlias(CLI::App& map, const Globals& globals) {
  CLI::App* group =
      map.add_subcommand("alias", "Names that lead to revisions, such as stable; such revisions are kept");
  group->require_subcommand(1);
  const auto set = std::make_shared<MapAliasCommandOptions>();
  CLI::App* command = AddCommand(*group, "set", "Make an alias, or lead it to another revision",
                                 [&globals, set] { return SetAlias(globals, *set); });
  AddAliasOptions(*command, set);
  command->add_option("--revision", set->revision, "The number of a revision, or another alias (default: the newest)");
  command->footer("Example: enfilade map alias set \"Main hall\" stable --revision 12");
  const auto listed = std::make_shared<std::string>();
  command = AddCommand(*group, "list", "Show where a map's aliases lead",
                       [&globals, listed] { return ListAliases(globals, *listed); });
  command->add_option("MAP", *listed, "Its name, id or resource name")->required();
  command->footer("Example: enfilade map alias list \"Main hall\"");
  const auto back = std::make_shared<MapAliasCommandOptions>();
  command = AddCommand(*group, "rollback", "Lead an alias back to where it led before",
                       [&globals, back] { return RollBackAlias(globals, *back); });
  AddAliasOptions(*command, back);
  command->footer("Example: enfilade map alias rollback \"Main hall\" stable");
  const auto gone = std::make_shared<MapAliasCommandOptions>();
  command = AddCommand(*group, "delete", "Delete an alias; its revision stays as long as the site keeps revisions",
                       [&globals, gone] { return DeleteAlias(globals, *gone); });
  AddAliasOptions(*command, gone);
  command->footer("Example: enfilade map alias delete \"Main hall\" canary");
  const auto revision = std::make_shared<std::string>();
  command = AddCommand(map, "restore", "Make the content of an older revision the newest one, in place of all layers",
                       [&globals, revision] { return RestoreRevision(globals, *revision); });
  command->add_option("REVISION", *revision, "MAP@REVISION or MAP@ALIAS, or a resource name")->required();
  command->footer("Example: enfilade map restore \"Main hall@stable\"");
}

}  // namespace enfilade::cli
