// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "core/graph/graph_snapshot.h"
#include "core/rearrange/rearrangement.h"
#include "proto/convert/names.h"
#include "server/app/services.h"
#include "server/rpc/call/call.h"

namespace enfilade::server {

// The map of the graph that a name in a request means, and the transform into its frame: an old name leads to the map
// that it was merged into. Only a map that the graph does not have costs a look into the database. A map that does not
// exist leads to itself.
absl::StatusOr<rearrange::MapRedirect> ResolveMap(const Services& services, const Call& call,
                                                  const graph::GraphSnapshot& graph, const convert::MapName& name);

}  // namespace enfilade::server
