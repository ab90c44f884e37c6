#include "client/cli/commands/site.h"

#include <iostream>
#include <memory>

#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/site_service.grpc.pb.h"

namespace enfilade::cli {
namespace {

nlohmann::json ToJson(const v1::Site& site) {
  nlohmann::json json{{"name", site.name()},
                      {"display_name", site.display_name()},
                      {"etag", site.etag()},
                      {"create_time", TimeInWords(site.create_time())}};
  if (site.has_raw_retention()) json["raw_retention_s"] = site.raw_retention().seconds();
  return json;
}

struct CreateOptions {
  std::string id;
  std::string display_name;
  std::int64_t retention_days = 0;
};

absl::Status Create(const Globals& globals, const CreateOptions& options) {
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

absl::Status List(const Globals& globals) {
  const Connection connection = ConnectionOf(globals);
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

}  // namespace

void AddSite(CLI::App& app, const Globals& globals) {
  CLI::App* site = app.add_subcommand("site", "Sites: the campuses that a server keeps apart");
  site->require_subcommand(1);
  auto options = std::make_shared<CreateOptions>();
  CLI::App* create =
      AddCommand(*site, "create", "Create a site", [&globals, options] { return Create(globals, *options); });
  create->add_option("ID", options->id, "Its id: 1 to 63 of a-z, 0-9 and \"-\"")->required();
  create->add_option("--name", options->display_name, "Its name for people");
  create->add_option("--retention-days", options->retention_days,
                     "Delete raw records so long after mapping (default: never)");
  create->footer("Example: enfilade site create campus --name \"North campus\"");
  AddCommand(*site, "list", "List the sites", [&globals] { return List(globals); });
}

}  // namespace enfilade::cli
