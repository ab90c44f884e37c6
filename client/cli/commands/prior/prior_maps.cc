// SPDX-License-Identifier: Apache-2.0
// `enfilade prior list`, `show`, `activate`, `suspend`, `rename` and `delete`.
#include "client/sdk/api/prior_maps.h"

#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/commands/prior/prior_map_output.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "client/sdk/api/paging.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/prior_map_service.grpc.pb.h"
#include "fmt/format.h"

namespace enfilade::cli {
namespace {

using PriorMapStub = v1::PriorMapService::Stub;

struct PriorMapsOptions {
  std::string plan;
  std::string new_name;
  bool force = false;
};

absl::Status ListPriorMaps(const Globals& globals) {
  v1::ListPriorMapsRequest request;
  request.set_parent(SiteNameOf(globals));
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<v1::PriorMap> listed,
                            client::ListAll(ConnectionOf(globals), &PriorMapStub::ListPriorMaps, request,
                                            &v1::ListPriorMapsResponse::prior_maps));
  PrintList<v1::PriorMap>(globals, listed, PriorMapHeader(), PriorMapToJson, PriorMapRow);
  return absl::OkStatus();
}

void PrintPriorAlignment(const v1::PriorAlignment& alignment) {
  std::cout << AlignmentText(alignment) << "\naligned";
  if (alignment.has_align_time()) std::cout << ' ' << FormatTime(alignment.align_time()) << " UTC";
  if (alignment.pairs_size() > 0) std::cout << " by " << alignment.pairs_size() << " pairs";
  std::cout << " with";
  for (const std::string& map : alignment.maps()) std::cout << ' ' << IdOf(map);
  std::cout << ", graph version " << alignment.graph_version() << '\n';
}

absl::Status ShowPriorMap(const Globals& globals, const std::string& plan) {
  ENFILADE_ASSIGN_OR_RETURN(const v1::PriorMap found,
                            client::FindPriorMap(ConnectionOf(globals), SiteId(globals.site), plan));
  if (globals.json) {
    PrintJson(std::cout, PriorMapToJson(found));
    return absl::OkStatus();
  }
  std::cout << found.display_name() << "\n"
            << found.name() << "  level " << found.level() << ", " << StateText(found.state())
            << (found.reason().empty() ? "" : ": ") << found.reason() << '\n'
            << found.file_name() << ": " << ElementsText(found.elements()) << '\n';
  for (const std::string& warning : found.warnings()) std::cout << "warning: " << warning << '\n';
  if (found.has_alignment()) PrintPriorAlignment(found.alignment());
  return absl::OkStatus();
}

// Activates or suspends it.
template <typename Request, typename Response>
absl::Status SwitchPriorMap(const Globals& globals, const std::string& plan,
                            grpc::Status (PriorMapStub::*method)(grpc::ClientContext*, const Request&, Response*),
                            const std::string& what) {
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const v1::PriorMap found, client::FindPriorMap(connection, SiteId(globals.site), plan));
  Request request;
  request.set_name(found.name());
  request.set_etag(found.etag());
  ENFILADE_ASSIGN_OR_RETURN(const Response response, connection.Call(method, request));
  PrintPriorMap(globals, what, response.prior_map());
  return absl::OkStatus();
}

absl::Status RenamePriorMap(const Globals& globals, const PriorMapsOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const v1::PriorMap found,
                            client::FindPriorMap(connection, SiteId(globals.site), options.plan));
  v1::UpdatePriorMapRequest request;
  request.mutable_prior_map()->set_name(found.name());
  request.mutable_prior_map()->set_etag(found.etag());
  request.mutable_prior_map()->set_display_name(options.new_name);
  request.mutable_update_mask()->add_paths("display_name");
  ENFILADE_ASSIGN_OR_RETURN(const auto response, connection.Call(&PriorMapStub::UpdatePriorMap, request));
  PrintPriorMap(globals, "renamed: now", response.prior_map());
  return absl::OkStatus();
}

absl::Status DeletePriorMap(const Globals& globals, const PriorMapsOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const v1::PriorMap found,
                            client::FindPriorMap(connection, SiteId(globals.site), options.plan));
  v1::DeletePriorMapRequest request;
  request.set_name(found.name());
  request.set_etag(found.etag());
  request.set_force(options.force);
  ENFILADE_RETURN_IF_ERROR(connection.Call(&PriorMapStub::DeletePriorMap, request).status());
  if (globals.json) {
    PrintJson(std::cout, {{"deleted", found.name()}});
  } else {
    std::cout << "deleted \"" << found.display_name() << "\" (" << found.name() << ")\n";
  }
  return absl::OkStatus();
}

}  // namespace

void AddPriorMaps(CLI::App& prior, const Globals& globals) {
  AddCommand(prior, "list", "List the site's plans", [&globals] { return ListPriorMaps(globals); });
  const auto options = std::make_shared<PriorMapsOptions>();
  const auto add = [&](const std::string& name, const std::string& description, auto run) {
    CLI::App* command = AddCommand(prior, name, description, run);
    command->add_option("PLAN", options->plan, "Its name, id or resource name")->required();
    command->footer("Example: enfilade prior " + name + " \"Ground floor\"");
    return command;
  };
  add("show", "Show a plan, and where it lies", [&globals, options] { return ShowPriorMap(globals, options->plan); });
  add("activate", "Say that a plan's alignment is right, or use a suspended plan again", [&globals, options] {
    return SwitchPriorMap(globals, options->plan, &PriorMapStub::ActivatePriorMap, "in use:");
  });
  add("suspend", "Switch a plan off", [&globals, options] {
    return SwitchPriorMap(globals, options->plan, &PriorMapStub::SuspendPriorMap, "suspended");
  });
  CLI::App* rename =
      add("rename", "Give a plan another name", [&globals, options] { return RenamePriorMap(globals, *options); });
  rename->add_option("NAME", options->new_name, "Its name for people, unique in the site")->required();
  rename->footer("Example: enfilade prior rename \"Ground floor\" \"Ground floor, 2026\"");
  CLI::App* remove = add("delete", "Delete a plan; maps stay as they are",
                         [&globals, options] { return DeletePriorMap(globals, *options); });
  remove->add_flag("--force", options->force, "Also one that is in use: what it ties loses that");
}

}  // namespace enfilade::cli
