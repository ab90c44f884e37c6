// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "client/sdk/connection.h"
#include "enfilade/v1/graph.pb.h"

namespace enfilade::client {

struct GraphRead {
  std::int64_t version = 0;  // 0: the current one
  bool with_edges = false;   // a map with d link points that join maps has d (d - 1) / 2
};

// The graph of sites/{site}, of any size, read page by page at one version; from the beginning if that version is gone
// meanwhile, up to five times. Each page has the connection's deadline. Errors as GraphService.GetGraph.
absl::StatusOr<v1::Graph> ReadGraph(const Connection& connection, const std::string& site, const GraphRead& read = {});

}  // namespace enfilade::client
