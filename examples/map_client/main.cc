// SPDX-License-Identifier: Apache-2.0
// usage: map_client SERVER SITE FOLDER            writes every map of the site as PNG and YAML into FOLDER
//        map_client SERVER SITE FOLDER BUILDING   the same, after importing an Open-RMF building.yaml
#include <chrono>
#include <filesystem>
#include <iostream>
#include <string>

#include "client/import/building_import.h"
#include "client/sdk/api/map_export.h"
#include "client/sdk/api/paging.h"
#include "enfilade/v1/map_service.grpc.pb.h"
#include "io/file.h"

namespace {

namespace client = enfilade::client;
namespace v1 = enfilade::v1;

absl::Status Import(const client::Connection& connection, const enfilade::SiteId& site, const std::string& path) {
  const absl::StatusOr<std::string> yaml = enfilade::io::ReadFile(path);
  if (!yaml.ok()) return yaml.status();
  const auto building = enfilade::prior::ParseBuilding(*yaml);
  if (!building.ok()) return building.status();
  client::ImportReport report;
  const absl::Status status = client::ImportBuilding(connection, site, *building, building->name + " ", {}, report);
  std::cout << report.taken() << " items imported, " << report.refused() << " refused\n";
  return status;
}

// A map without a revision has no files yet: FAILED_PRECONDITION.
absl::Status ExportAll(const client::Connection& connection, const std::string& site,
                       const std::filesystem::path& folder) {
  v1::ListMapsRequest request;
  request.set_parent("sites/" + site);
  const auto maps = client::ListAll(connection, &v1::MapService::Stub::ListMaps, request, &v1::ListMapsResponse::maps);
  if (!maps.ok()) return maps.status();
  for (const v1::Map& map : *maps) {
    v1::ExportMapRequest export_request;
    export_request.set_name(map.name());
    export_request.set_format(v1::MAP_FORMAT_PNG);
    const auto exported = client::ExportMap(connection, export_request, folder);
    if (absl::IsFailedPrecondition(exported.status())) {
      std::cout << map.display_name() << ": no revision\n";
      continue;
    }
    if (!exported.ok()) return exported.status();
    std::cout << map.display_name() << ": " << exported->revision.width() << " x " << exported->revision.height()
              << " cells in " << exported->files.size() << " files\n";
  }
  return absl::OkStatus();
}

absl::Status Run(int argc, char** argv) {
  const client::Connection connection(argv[1], std::chrono::seconds(10), "map_client");
  if (argc == 5) {
    const absl::Status status = Import(connection, enfilade::SiteId(argv[2]), argv[4]);
    if (!status.ok()) return status;
  }
  return ExportAll(connection, argv[2], argv[3]);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4 && argc != 5) {
    std::cerr << "usage: map_client SERVER SITE FOLDER [BUILDING]\n";
    return 2;
  }
  if (const absl::Status status = Run(argc, argv); !status.ok()) {
    std::cerr << "map_client: " << status << '\n';
    return 1;
  }
}
