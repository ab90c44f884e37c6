// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/site.h"

#include <iostream>
#include <memory>

#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/site_service.grpc.pb.h"

namespace enfilade::cli {
namespace {

const char* ActionInWords(v1::AuditEntry::Action action) {
  switch (action) {
    case v1::AuditEntry::ACTION_CREATED:
      return "created";
    case v1::AuditEntry::ACTION_UPDATED:
      return "updated";
    case v1::AuditEntry::ACTION_DELETED:
      return "deleted";
    default:
      return "unknown";
  }
}

nlohmann::json ToJson(const v1::Site& site) {
  nlohmann::json json{{"name", site.name()},
                      {"display_name", site.display_name()},
                      {"etag", site.etag()},
                      {"create_time", TimeInWords(site.create_time())}};
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

absl::Status ListSites(const Globals& globals) {
  const client::Connection connection = ConnectionOf(globals);
  nlohmann::json documents = nlohmann::json::array();
  std::vector<std::vector<std::string>> rows;
  v1::ListSitesRequest request;
  do {
    ENFILADE_ASSIGN_OR_RETURN(const v1::ListSitesResponse page,
                              connection.Call(&v1::SiteService::Stub::ListSites, request));
    for (const v1::Site& site : page.sites()) {
      documents.push_back(ToJson(site));
      const std::string kept =
          site.has_raw_retention() ? SecondsInWords(static_cast<double>(site.raw_retention().seconds())) : "for ever";
      rows.push_back({IdOf(site.name()), site.display_name(), kept, TimeInWords(site.create_time())});
    }
    request.set_page_token(page.next_page_token());
  } while (!request.page_token().empty());
  if (globals.json) {
    PrintJson(std::cout, documents);
  } else {
    PrintTable(std::cout, {"SITE", "NAME", "RAW RECORDS KEPT", "CREATED (UTC)"}, rows);
  }
  return absl::OkStatus();
}

struct AuditCommandOptions {
  std::string resource;
  int count = 50;
};

nlohmann::json ToJson(const v1::AuditEntry& entry) {
  nlohmann::json json{{"time", TimeInWords(entry.time())},
                      {"actor", entry.actor()},
                      {"action", ActionInWords(entry.action())},
                      {"resource", entry.resource()}};
  if (!entry.before().empty()) json["before"] = nlohmann::json::parse(entry.before(), nullptr, false);
  if (!entry.after().empty()) json["after"] = nlohmann::json::parse(entry.after(), nullptr, false);
  return json;
}

absl::Status PrintAudit(const Globals& globals, const AuditCommandOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  const std::string site = SiteNameOf(globals);
  v1::ListAuditEntriesRequest request;
  request.set_parent(site);
  if (!options.resource.empty()) request.set_resource(site + "/" + options.resource);
  request.set_page_size(options.count);
  ENFILADE_ASSIGN_OR_RETURN(const v1::ListAuditEntriesResponse page,
                            connection.Call(&v1::SiteService::Stub::ListAuditEntries, request));
  nlohmann::json documents = nlohmann::json::array();
  std::vector<std::vector<std::string>> rows;
  for (const v1::AuditEntry& entry : page.entries()) {
    documents.push_back(ToJson(entry));
    rows.push_back({TimeInWords(entry.time()), entry.actor().empty() ? "-" : entry.actor(),
                    ActionInWords(entry.action()), entry.resource().substr(site.size() + 1)});
  }
  if (globals.json) {
    PrintJson(std::cout, documents);
  } else {
    PrintTable(std::cout, {"TIME (UTC)", "WHO", "DID", "RESOURCE"}, rows);
  }
  return absl::OkStatus();
}

}  // namespace

void AddSite(CLI::App& app, const Globals& globals) {
  CLI::App* site = app.add_subcommand("site", "Sites: the campuses that a server keeps apart");
  site->require_subcommand(1);
  auto options = std::make_shared<CreateSiteCommandOptions>();
  CLI::App* create =
      AddCommand(*site, "create", "Create a site", [&globals, options] { return CreateSite(globals, *options); });
  create->add_option("ID", options->id, "Its id: 1 to 63 of a-z, 0-9 and \"-\"")->required();
  create->add_option("--name", options->display_name, "Its name for people");
  create->add_option("--retention-days", options->retention_days,
                     "Delete raw records so long after mapping (default: never)");
  create->footer("Example: enfilade site create campus --name \"North campus\"");
  AddCommand(*site, "list", "List the sites", [&globals] { return ListSites(globals); });
  auto audit_options = std::make_shared<AuditCommandOptions>();
  CLI::App* audit = AddCommand(*site, "audit", "Who changed which map or link point when, the newest first",
                               [&globals, audit_options] { return PrintAudit(globals, *audit_options); });
  audit->add_option("RESOURCE", audit_options->resource, "Only this one and what is below it: maps/ID, linkPoints/ID");
  audit->add_option("-n,--count", audit_options->count, "How many")->capture_default_str()->check(CLI::Range(1, 1000));
  audit->footer("Example: enfilade site audit linkPoints/door-1 --json");
}

}  // namespace enfilade::cli
