// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "client/sdk/api/paging.h"
#include "core/base/error.h"
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
  if (site.has_session_retention()) json["session_retention_s"] = site.session_retention().seconds();
  if (site.has_revision_retention()) {
    json["revisions_kept"] = site.revision_retention().newest();
    if (site.revision_retention().has_age()) {
      json["revision_retention_s"] = site.revision_retention().age().seconds();
    }
  }
  if (site.has_history_retention()) json["history_retention_s"] = site.history_retention().seconds();
  if (site.has_audit_retention()) json["audit_retention_s"] = site.audit_retention().seconds();
  return json;
}

struct SiteCommandOptions {
  std::string id;
  std::string display_name;
  // Days; unset: not given; negative: for ever.
  std::optional<std::int64_t> records_days, session_days, revision_days, history_days, audit_days;
  std::optional<int> revisions;
};

// Sets `field` if `days` is given and not negative.
void SetDays(const std::optional<std::int64_t>& days, google::protobuf::Duration* (v1::Site::*field)(),
             v1::Site& site) {
  constexpr std::int64_t kSecondsPerDay = 86'400;
  if (days && *days >= 0) (site.*field)()->set_seconds(*days * kSecondsPerDay);
}

void SetFields(const SiteCommandOptions& options, v1::Site& site) {
  site.set_display_name(options.display_name);
  SetDays(options.records_days, &v1::Site::mutable_raw_retention, site);
  SetDays(options.session_days, &v1::Site::mutable_session_retention, site);
  SetDays(options.history_days, &v1::Site::mutable_history_retention, site);
  SetDays(options.audit_days, &v1::Site::mutable_audit_retention, site);
  if (options.revisions && *options.revisions > 0) {
    site.mutable_revision_retention()->set_newest(*options.revisions);
    if (options.revision_days) {
      site.mutable_revision_retention()->mutable_age()->set_seconds(*options.revision_days * 86'400);
    }
  }
}

absl::Status UpdateSite(const Globals& globals, const SiteCommandOptions& options) {
  v1::UpdateSiteRequest request;
  SetFields(options, *request.mutable_site());
  request.mutable_site()->set_name("sites/" + options.id);
  const std::pair<const char*, bool> fields[] = {
      {"display_name", !options.display_name.empty()},         {"raw_retention", options.records_days.has_value()},
      {"session_retention", options.session_days.has_value()}, {"revision_retention", options.revisions.has_value()},
      {"history_retention", options.history_days.has_value()}, {"audit_retention", options.audit_days.has_value()}};
  for (const auto& [field, given] : fields) {
    if (given) request.mutable_update_mask()->add_paths(field);
  }
  if (request.update_mask().paths().empty())
    return InvalidArgument("nothing to change: see enfilade site update --help");
  ENFILADE_ASSIGN_OR_RETURN(const v1::UpdateSiteResponse response,
                            ConnectionOf(globals).Call(&v1::SiteService::Stub::UpdateSite, request));
  if (globals.json) {
    PrintJson(std::cout, ToJson(response.site()));
  } else {
    std::cout << "updated " << response.site().name() << '\n';
  }
  return absl::OkStatus();
}

absl::Status CreateSite(const Globals& globals, const SiteCommandOptions& options) {
  v1::CreateSiteRequest request;
  request.set_site_id(options.id);
  SetFields(options, *request.mutable_site());
  if (options.display_name.empty()) request.mutable_site()->set_display_name(options.id);
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
  nlohmann::json json{{"id", entry.id()},
                      {"time", FormatTime(entry.time())},
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
          site_end == std::string::npos ? entry.resource() : entry.resource().substr(site_end + 1), entry.id()};
}

absl::Status PrintAudit(const Globals& globals, const AuditCommandOptions& options) {
  v1::ListAuditEntriesRequest request;
  request.set_parent(SiteNameOf(globals));
  if (!options.resource.empty()) request.set_resource(request.parent() + "/" + options.resource);
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<v1::AuditEntry> entries,
                            client::ListAll(ConnectionOf(globals), &v1::SiteService::Stub::ListAuditEntries, request,
                                            &v1::ListAuditEntriesResponse::entries, options.count));
  PrintList<v1::AuditEntry>(globals, entries, {"TIME (UTC)", "WHO", "DID", "RESOURCE", "ENTRY"}, ToJson, ToRow);
  return absl::OkStatus();
}

void AddSiteFields(CLI::App& command, const std::shared_ptr<SiteCommandOptions>& options) {
  command.add_option("ID", options->id, "Its id: 1 to 63 of a-z, 0-9 and \"-\"")->required();
  command.add_option("--name", options->display_name, "Its name for people");
  const CLI::Range days(-1, 36'500);
  command
      .add_option("--retention-days", options->records_days,
                  "Delete raw records this many days after mapping (-1, the default: never)")
      ->check(days);
  command
      .add_option("--session-days", options->session_days,
                  "Delete sessions this many days after they have finished (-1, the default: never)")
      ->check(days);
  CLI::Option* revisions = command.add_option("--revisions", options->revisions,
                                              "Keep so many of a map's newest revisions (0, the default: all)");
  revisions->check(CLI::Range(0, 1'000'000));
  command.add_option("--revision-days", options->revision_days, "And those that are not older than so many days")
      ->check(CLI::Range(0, 36'500))
      ->needs(revisions);
  command
      .add_option("--history-days", options->history_days,
                  "Delete versions of the graph this many days old (-1, the default: never)")
      ->check(days);
  command
      .add_option("--audit-days", options->audit_days,
                  "Delete audit entries this many days old (-1, the default: never)")
      ->check(days);
}

}  // namespace

void AddSite(CLI::App& app, const Globals& globals) {
  CLI::App* site = app.add_subcommand("site", "Sites: the separate campuses of a server");
  site->require_subcommand(1);
  auto options = std::make_shared<SiteCommandOptions>();
  CLI::App* create =
      AddCommand(*site, "create", "Create a site", [&globals, options] { return CreateSite(globals, *options); });
  AddSiteFields(*create, options);
  create->footer("Example: enfilade site create campus --name \"North campus\"");
  CLI::App* update = AddCommand(*site, "update", "Change a site's name, or how long it keeps things",
                                [&globals, options] { return UpdateSite(globals, *options); });
  AddSiteFields(*update, options);
  update->footer("Example: enfilade site update campus --revisions 20 --revision-days 7 --audit-days 365");
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
