// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/rearrange/resolve_map.h"

namespace enfilade::server {

absl::StatusOr<rearrange::MapRedirect> ResolveMap(const Services& services, const Call& call,
                                                  const graph::GraphSnapshot& graph, const convert::MapName& name) {
  if (graph.FindMap(name.map) != nullptr) return rearrange::MapRedirect{name.map, name.map, {}};
  return services.rearrangement_store.Resolve(call.context(), name.site, name.map);
}

}  // namespace enfilade::server
