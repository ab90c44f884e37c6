// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/cli/command.h"
#include "client/cli/output.h"
#include "client/sdk/api/chunks.h"
#include "client/sdk/connection.h"
#include "core/base/ids.h"
#include "core/grid/files/map_files.h"
#include "enfilade/v1/map_service.pb.h"

namespace enfilade::cli {

// How far a transfer is, on a progress bar, which must outlive the result.
client::TransferProgress ShownBy(ProgressBar& bar);

// Where files are imported to, and how.
struct MapFileTarget {
  SiteId site;
  std::string map;  // its name, id or resource name; created under that name if missing
  int level = 0;    // if it is created
  v1::MapDialect dialect = v1::MAP_DIALECT_NAV2;
  bool keep_edits = false;
};

// Makes files the newest revision of a map, and prints it, with the server's warnings. Errors as client::ImportMap.
absl::Status ImportMapFiles(const Globals& globals, const client::Connection& connection,
                            std::vector<grid::MapFile> files, const MapFileTarget& target);

}  // namespace enfilade::cli
