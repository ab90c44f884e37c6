// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/sdk/api/chunks.h"
#include "client/sdk/connection.h"
#include "enfilade/v1/map.pb.h"
#include "enfilade/v1/map_service.pb.h"

namespace enfilade::client {

struct DownloadedMap {
  v1::MapRevision revision;
  std::vector<NamedFile> files;
};

struct ExportedMap {
  v1::MapRevision revision;
  std::vector<std::filesystem::path> files;
  std::int64_t bytes = 0;  // of all files
};

// The files of a map's newest revision, or of the revision that `request` names. The SHA-256 of every file is checked.
// No deadline: a large map may take minutes. Errors as MapService.ExportMap, and DATA_LOSS: damaged or incomplete.
absl::StatusOr<DownloadedMap> DownloadMap(const Connection& connection, const v1::ExportMapRequest& request,
                                          const TransferProgress& progress = {});

// Likewise, into files in `folder`, which is created if missing. A file gets its name once all of them are complete and
// checked: until then, and after an error, an earlier export is left as it was. INVALID_ARGUMENT: the folder cannot be
// created or written to; RESOURCE_EXHAUSTED: the disk is full.
absl::StatusOr<ExportedMap> ExportMap(const Connection& connection, const v1::ExportMapRequest& request,
                                      const std::filesystem::path& folder, const TransferProgress& progress = {});

}  // namespace enfilade::client
