// SPDX-License-Identifier: Apache-2.0
#include "client/cli/map_file_import.h"

#include <iostream>
#include <utility>

#include "client/cli/map_revision.h"
#include "client/sdk/api/map_import.h"
#include "client/sdk/api/maps.h"
#include "core/base/status_macros.h"

namespace enfilade::cli {

client::TransferProgress ShownBy(ProgressBar& bar) {
  return [&bar](std::int64_t done, std::int64_t total) {
    bar.SetTotal(total);
    bar.Update(done);
  };
}

absl::Status ImportMapFiles(const Globals& globals, const client::Connection& connection,
                            std::vector<grid::MapFile> files, const MapFileTarget& target) {
  std::vector<client::NamedFile> named;
  for (grid::MapFile& file : files) named.push_back({std::move(file.name), std::move(file.bytes)});
  v1::CreateMapRequest fresh;
  fresh.mutable_map()->set_display_name(target.map);
  fresh.mutable_map()->set_level(target.level);
  ENFILADE_ASSIGN_OR_RETURN(const v1::Map map, client::FindOrCreateMap(connection, target.site, target.map, fresh));
  ProgressBar bar(globals, "uploading", 0, "B");
  ENFILADE_ASSIGN_OR_RETURN(
      const v1::ImportMapResponse response,
      client::ImportMap(connection, map.name(), target.dialect, named, ShownBy(bar), target.keep_edits));
  bar.Finish();
  for (const std::string& warning : response.warnings()) std::cerr << "warning: " << warning << '\n';
  if (globals.json) {
    PrintJson(std::cout, RevisionToJson(response.revision()));
  } else {
    PrintRevision(response.revision());
  }
  return absl::OkStatus();
}

}  // namespace enfilade::cli
