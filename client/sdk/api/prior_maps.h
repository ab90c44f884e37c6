// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "client/sdk/api/chunks.h"
#include "client/sdk/connection.h"
#include "core/base/ids.h"
#include "enfilade/v1/prior_map.pb.h"
#include "enfilade/v1/prior_map_service.pb.h"

namespace enfilade::client {

// The prior map of a site that `prior_map` means: its display name, its id or its resource name, in this order.
// NOT_FOUND.
absl::StatusOr<v1::PriorMap> FindPriorMap(const Connection& connection, const SiteId& site,
                                          const std::string& prior_map);

// Makes a floor plan a prior map. `manifest`: all but `file`, which is set here. No deadline. Errors as
// PriorMapService.ImportPriorMap.
absl::StatusOr<v1::PriorMap> ImportPriorMap(const Connection& connection, v1::ImportPriorMapManifest manifest,
                                            const NamedFile& file, const TransferProgress& progress = {});

// Likewise, of a file on disk, which is sent under its name without the folder. NOT_FOUND and others: it cannot be
// read.
absl::StatusOr<v1::PriorMap> ImportPriorMap(const Connection& connection, v1::ImportPriorMapManifest manifest,
                                            const std::filesystem::path& file, const TransferProgress& progress = {});

// Writes a prior map's products into files in `folder`, which is created if missing, and returns their paths. `name`:
// sites/{site}/priorMaps/{prior_map}; `products`: empty: all that there are. The SHA-256 of every file is checked. A
// file gets its name once all of them are complete: after an error, an earlier export is left as it was. No deadline.
// Errors as PriorMapService.ExportPriorMap, and DATA_LOSS: damaged or incomplete; INVALID_ARGUMENT: the folder cannot
// be created or written to; RESOURCE_EXHAUSTED: the disk is full.
absl::StatusOr<std::vector<std::filesystem::path>> ExportPriorMap(const Connection& connection, const std::string& name,
                                                                  absl::Span<const v1::PriorMapProduct> products,
                                                                  const std::filesystem::path& folder,
                                                                  const TransferProgress& progress = {});

}  // namespace enfilade::client
