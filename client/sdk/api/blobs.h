// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "client/sdk/api/chunks.h"
#include "client/sdk/connection.h"
#include "core/base/ids.h"

namespace enfilade::client {

// The bytes of an image or a point cloud that the site has under `sha256` (32 bytes, as in a record's BlobRef). The
// bytes are checked against it. Errors as IngestService.DownloadBlob, and DATA_LOSS: damaged or incomplete.
absl::StatusOr<std::string> DownloadBlob(const Connection& connection, const SiteId& site, const std::string& sha256,
                                         const TransferProgress& progress = {});

}  // namespace enfilade::client
