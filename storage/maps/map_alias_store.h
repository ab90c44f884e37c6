// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/base/time.h"
#include "storage/call_context.h"

namespace enfilade::storage {
namespace postgres {
class Pool;
}

// A name that leads to a revision of a map.
struct MapAlias {
  SiteId site;
  MapId map;
  MapAliasId id;
  std::int64_t revision = 0;
  // Set by the store.
  std::int64_t previous_revision = 0;  // where it led before; 0: nowhere
  std::string actor = {};              // who moved it last
  std::int64_t etag = 0;
  TimeNs update_time = 0;
};

// The aliases of maps. They go with their map, and keep the revisions to which they lead and can be led back.
// Thread-safe; errors common to all stores: see SiteStore.
class MapAliasStore {
 public:
  // Of a map.
  static constexpr int kMaxAliases = 100;

  explicit MapAliasStore(postgres::Pool& pool) : pool_(pool) {}

  // Makes the alias, or leads it to `alias.revision`; nothing changes if it leads there already. NOT_FOUND naming the
  // map, the revision or, with an etag, the alias; ABORTED on a stale `alias.etag` (0: any); RESOURCE_EXHAUSTED if the
  // map has kMaxAliases others.
  absl::StatusOr<MapAlias> Set(const CallContext& context, const MapAlias& alias) const;
  // Leads the alias to where it led before, which it then can be led back from. NOT_FOUND; ABORTED on a stale `etag`
  // (0: any); FAILED_PRECONDITION if it has never led elsewhere.
  absl::StatusOr<MapAlias> RollBack(const CallContext& context, const SiteId& site, const MapId& map,
                                    const MapAliasId& id, std::int64_t etag) const;
  // NOT_FOUND.
  absl::StatusOr<MapAlias> Get(const CallContext& context, const SiteId& site, const MapId& map,
                               const MapAliasId& id) const;
  // By id. NOT_FOUND if the map does not exist.
  absl::StatusOr<std::vector<MapAlias>> List(const CallContext& context, const SiteId& site, const MapId& map) const;
  // NOT_FOUND; ABORTED on a stale `etag` (0: any).
  absl::Status Delete(const CallContext& context, const SiteId& site, const MapId& map, const MapAliasId& id,
                      std::int64_t etag) const;

 private:
  postgres::Pool& pool_;
};

}  // namespace enfilade::storage
