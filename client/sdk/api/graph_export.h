// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "client/sdk/connection.h"
#include "core/base/ids.h"

namespace enfilade::client {

struct ExportedGraph {
  std::int64_t version = 0;
  std::string geojson;  // RFC 7946
};

struct GraphContent {
  bool with_edges = true;  // one for each two link points of a map
};

// The site's graph of maps and link points. Within the connection's deadline. The SHA-256 is checked. Errors as
// GraphService.ExportGraph, and DATA_LOSS: damaged or incomplete.
absl::StatusOr<ExportedGraph> ExportGraph(const Connection& connection, const SiteId& site,
                                          const GraphContent& content = {});

}  // namespace enfilade::client
