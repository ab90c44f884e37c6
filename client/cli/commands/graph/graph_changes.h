// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/cli/command.h"
#include "client/sdk/connection.h"
#include "enfilade/v1/graph_service.pb.h"

namespace enfilade::cli {

// Makes the changes, all or none, and prints what was changed; or, with `preview`, prints what they would do to the
// graph.
absl::Status RunGraphChanges(const Globals& globals, const client::Connection& connection,
                             const std::vector<v1::GraphChange>& changes, bool preview);

constexpr char kPreviewHelp[] = "Show what it would do to the graph, and change nothing";

}  // namespace enfilade::cli
