// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/sdk/api/chunks.h"
#include "client/sdk/connection.h"
#include "enfilade/v1/map_area.pb.h"
#include "enfilade/v1/map_area_service.pb.h"

namespace enfilade::client {

// All areas of a map (sites/{site}/maps/{map}), by id. NOT_FOUND.
absl::StatusOr<std::vector<v1::MapArea>> ListMapAreas(const Connection& connection, const std::string& map);

// The area of a map (sites/{site}/maps/{map}) that `area` means: its id, its resource name or its display name, in this
// order. NOT_FOUND; FAILED_PRECONDITION: several have that display name.
absl::StatusOr<v1::MapArea> FindMapArea(const Connection& connection, const std::string& map, const std::string& area);

// Writes areas into files in `folder`, which is created if missing, and returns their paths. The SHA-256 of every file
// is checked. A file gets its name once all of them are complete: after an error, an earlier export is left as it was.
// No deadline. Errors as MapAreaService.ExportMapAreas, and as ExportPriorMap for the files.
absl::StatusOr<std::vector<std::filesystem::path>> ExportMapAreas(const Connection& connection,
                                                                  const v1::ExportMapAreasRequest& request,
                                                                  const std::filesystem::path& folder,
                                                                  const TransferProgress& progress = {});

}  // namespace enfilade::client
