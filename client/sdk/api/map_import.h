// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "client/sdk/api/chunks.h"
#include "client/sdk/connection.h"
#include "enfilade/v1/map_service.pb.h"

namespace enfilade::client {

// Makes files a map's newest revision. `map`: sites/{site}/maps/{map}; `files`: a YAML file and the PGM or PNG that it
// names, or one JSON file; `dialect`: whose rules the YAML's thresholds follow; `keep_edits`: published
// edits are laid over the files, instead of ending. The response has the new revision and
// the server's warnings. No deadline: a large map may take minutes. Errors as MapService.ImportMap.
absl::StatusOr<v1::ImportMapResponse> ImportMap(const Connection& connection, const std::string& map,
                                                v1::MapDialect dialect, absl::Span<const NamedFile> files,
                                                const TransferProgress& progress = {}, bool keep_edits = false);

}  // namespace enfilade::client
