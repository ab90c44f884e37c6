// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "server/app/graph/site_graph.h"
#include "storage/call_context.h"
#include "storage/graph/graph_store.h"

namespace enfilade::server {

// The site's graph at its current version: `old` (null: none) itself if nothing has changed since, otherwise `old` with
// the changes. NOT_FOUND if there is no such site.
absl::StatusOr<std::shared_ptr<const SiteGraph>> ReadSiteGraph(const storage::GraphStore& store,
                                                               const storage::CallContext& context, const SiteId& site,
                                                               const std::shared_ptr<const SiteGraph>& old);

}  // namespace enfilade::server
