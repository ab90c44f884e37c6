// SPDX-License-Identifier: Apache-2.0
// `enfilade prior publish`.
#include <stdlib.h>  // mkdtemp

#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/map_file_import.h"
#include "client/cli/map_file_reader.h"
#include "client/cli/remote.h"
#include "client/sdk/api/prior_maps.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::cli {
namespace {

struct PriorPublishOptions {
  std::string plan;
  std::string site;
  std::string map;
};

// A folder for the files on their way, removed with its scope.
class FolderForFiles {
 public:
  static absl::StatusOr<FolderForFiles> Make() {
    std::error_code error;
    std::string path = (std::filesystem::temp_directory_path(error) / "enfilade-XXXXXX").string();
    if (error || mkdtemp(path.data()) == nullptr) return FailedPrecondition("{}: no folder can be made", path);
    return FolderForFiles(path);
  }
  FolderForFiles(FolderForFiles&& other) noexcept : path_(std::exchange(other.path_, {})) {}
  FolderForFiles& operator=(FolderForFiles&&) = delete;
  ~FolderForFiles() {
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  explicit FolderForFiles(std::filesystem::path path) : path_(std::move(path)) {}

  std::filesystem::path path_;
};

absl::StatusOr<std::vector<grid::MapFile>> ReadPlanningMap(const client::Connection& connection,
                                                           const std::string& prior_map) {
  ENFILADE_ASSIGN_OR_RETURN(const FolderForFiles folder, FolderForFiles::Make());
  ENFILADE_RETURN_IF_ERROR(
      client::ExportPriorMap(connection, prior_map, {v1::PRIOR_MAP_PRODUCT_PLANNING}, folder.path()).status());
  return ReadMapFiles(folder.path() / "planning.yaml");
}

absl::Status RunPriorPublish(const Globals& globals, const PriorPublishOptions& options) {
  if (options.site == globals.site) {
    return InvalidArgument(
        "--to is the plan's own site: robots would take the planning map for a place that they have been to; create a "
        "site for planning maps");
  }
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const v1::PriorMap plan,
                            client::FindPriorMap(connection, SiteId(globals.site), options.plan));
  ENFILADE_ASSIGN_OR_RETURN(std::vector<grid::MapFile> files, ReadPlanningMap(connection, plan.name()));
  return ImportMapFiles(globals, connection, std::move(files),
                        {.site = SiteId(options.site),
                         .map = options.map.empty() ? plan.display_name() : options.map,
                         .level = plan.level()});
}

}  // namespace

void AddPriorPublish(CLI::App& prior, const Globals& globals) {
  const auto options = std::make_shared<PriorPublishOptions>();
  CLI::App* command = AddCommand(prior, "publish", "Make a plan's planning map the newest revision of a map",
                                 [&globals, options] { return RunPriorPublish(globals, *options); });
  command->add_option("PLAN", options->plan, "Its name, id or resource name")->required();
  command->add_option("--to", options->site, "The site of the map, another one than the plan's")->required();
  command->add_option("--map", options->map, "The map there, created if missing (default: as the plan is called)");
  command->footer("Example: enfilade --site campus prior publish \"Ground floor\" --to campus-planning");
}

}  // namespace enfilade::cli
