// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "client/sdk/api/paging.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/site_service.grpc.pb.h"

namespace enfilade::cli {
namespace {

std::string ActionName(v1::AuditEntry::Action action) {
  return action == v1::AuditEntry::ACTION_UNSPECIFIED ? "unknown"
                                                      : EnumText(v1::AuditEntry::Action_Name(action), "ACTION_");
}

nlohmann::json ToJson(const v1::Site& site) {
  nlohmann::json json{{"name", site.name()},
                      {"display_name", site.display_name()},
                      {"etag", site.etag()},
                      {"create_time", FormatTime(site.create_time())}};
  if (site.has_raw_retention()) json["raw_retention_s"] = site.raw_retention().seconds();
  return json;
}

struct CreateSiteCommandOptions {
  std::string id;
  std::string display_name;
  std::int64_t retention_days = 0;
};

absl::Status CreateSite(const Globals& globals, const CreateSiteCommandOptions& options) {
  v1::CreateSiteRequest request;
  request.set_site_id(options.id);
  request.mutable_site()->set_display_name(options.display_name.empty() ? options.id : options.display_name);
  if (options.retention_days > 0) {
    request.mutable_site()->mutable_raw_retention()->set_seconds(options.retention_days * 86'400);
  }
  ENFILADE_ASSIGN_OR_RETURN(const v1::CreateSiteResponse response,
                            ConnectionOf(globals).Call(&v1::SiteService::Stub::CreateSite, request));
  if (globals.json) {
    PrintJson(std::cout, ToJson(response.site()));
  } else {
    std::cout << "created " << response.site().name() << '\n';
  }
  return absl::OkStatus();
}

std::vector<std::string> ToRow(const v1::Site& site) {
  return {IdOf(site.name()), site.display_name(),
          site.has_raw_retention() ? FormatSeconds(static_cast<double>(site.raw_retention().seconds())) : "forever",
          FormatTime(site.create_time())};
}

absl::Status ListSites(const Globals& globals) {
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<v1::Site> sites,
                            client::ListAll(ConnectionOf(globals), &v1::SiteService::Stub::ListSites,
                                            v1::ListSitesRequest(), &v1::ListSitesResponse::sites));
  PrintList<v1::Site>(globals, sites, {"SITE", "NAME", "RAW RECORDS KEPT", "CREATED (UTC)"}, ToJson, ToRow);
  return absl::OkStatus();
}

struct AuditCommandOptions {
  std::string resource;
  int count = 50;
};

// A resource as JSON; text that is not JSON stays a string, so that the document around it stays valid.
nlohmann::json ParseState(const std::string& text) {
  nlohmann::json state = nlohmann::json::parse(text, nullptr, false);
  return state.is_discarded() ? nlohmann::json(text) : state;
}

nlohmann::json ToJson(const v1::AuditEntry& entry) {
  nlohmann::json json{{"time", FormatTime(entry.time())},
                      {"actor", entry.actor()},
                      {"action", ActionName(entry.action())},
                      {"resource", entry.resource()}};
  if (!entry.before().empty()) json["before"] = ParseState(entry.before());
  if (!entry.after().empty()) json["after"] = ParseState(entry.after());
  return json;
}

// The resource without the site's name.
std::vector<std::string> ToRow(const v1::AuditEntry& entry) {
  const std::size_t site_end = entry.resource().find('/', sizeof("sites/") - 1);
  return {FormatTime(entry.time()), entry.actor().empty() ? "-" : entry.actor(), ActionName(entry.action()),
          site_end == std::string::npos ? entry.resource() : entry.resource().substr(site_end + 1)};
}

absl::Status PrintAudit(const Globals& globals, const AuditCommandOptions& options) {
  v1::ListAuditEntriesRequest request;
  request.set_parent(SiteNameOf(globals));
  if (!options.resource.empty()) request.set_resource(request.parent() + "/" + options.resource);
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<v1::AuditEntry> entries,
                            client::ListAll(ConnectionOf(globals), &v1::SiteService::Stub::ListAuditEntries, request,
                                            &v1::ListAuditEntriesResponse::entries, options.count));
  PrintList<v1::AuditEntry>(globals, entries, {"TIME (UTC)", "WHO", "DID", "RESOURCE"}, ToJson, ToRow);
  return absl::OkStatus();
}

}  // namespace

void AddSite(CLI::App& app, const Globals& globals) {
  CLI::App* site = app.add_subcommand("site", "Sites: the separate campuses of a server");
  site->require_subcommand(1);
  auto options = std::make_shared<CreateSiteCommandOptions>();
  CLI::App* create =
      AddCommand(*site, "create", "Create a site", [&globals, options] { return CreateSite(globals, *options); });
  create->add_option("ID", options->id, "Its id: 1 to 63 of a-z, 0-9 and \"-\"")->required();
  create->add_option("--name", options->display_name, "Its name for people");
  create->add_option("--retention-days", options->retention_days,
                     "Delete raw records this many days after mapping (default: never)");
  create->footer("Example: enfilade site create campus --name \"North campus\"");
  AddCommand(*site, "list", "List the sites", [&globals] { return ListSites(globals); });
  auto audit_options = std::make_shared<AuditCommandOptions>();
  CLI::App* audit = AddCommand(*site, "audit", "Show who changed which map or link point, the newest first",
                               [&globals, audit_options] { return PrintAudit(globals, *audit_options); });
  audit->add_option("RESOURCE", audit_options->resource,
                    "Only this resource and those below it: maps/ID, linkPoints/ID");
  audit->add_option("-n,--count", audit_options->count, "How many")->capture_default_str()->check(CLI::Range(1, 1000));
  audit->footer("Example: enfilade site audit linkPoints/door-1 --json");
}

}  // namespace enfilade::cli
