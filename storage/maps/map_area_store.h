// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/areas/map_area.h"
#include "core/base/ids.h"
#include "core/base/time.h"
#include "storage/call_context.h"
#include "storage/request_id.h"

namespace enfilade::storage {
namespace postgres {
class Pool;
}

struct MapArea {
  SiteId site;
  MapId map;
  MapAreaId id;
  areas::MapArea area;
  // Set by the store.
  std::int64_t etag = 0;
  TimeNs create_time = 0;
  TimeNs update_time = 0;
};

constexpr std::int64_t kMaxAreasOfMap = 10'000;

// Areas of maps. Those of a map that is merged or split go with it (docs/areas.md); those of a map that is deleted go
// with it. Thread-safe; errors common to all stores: see SiteStore. Times are kept in microseconds.
class MapAreaStore {
 public:
  explicit MapAreaStore(postgres::Pool& pool) : pool_(pool) {}

  // ALREADY_EXISTS; NOT_FOUND if the map does not exist or was merged into another; RESOURCE_EXHAUSTED if it has
  // kMaxAreasOfMap; INVALID_ARGUMENT as in areas::Validate. Unless `force`, FAILED_PRECONDITION naming the link points
  // if it is a keep-out area over their anchors in this map. `request_id` as in SiteStore.
  absl::StatusOr<MapArea> Create(const CallContext& context, const MapArea& area, const RequestId& request_id,
                                 bool force) const;
  // The id of a map that was merged into another leads to that map. NOT_FOUND.
  absl::StatusOr<MapArea> Get(const CallContext& context, const SiteId& site, const MapId& map,
                              const MapAreaId& id) const;
  // By id. Maps as in Get. NOT_FOUND if the map does not exist.
  absl::StatusOr<std::vector<MapArea>> List(const CallContext& context, const SiteId& site, const MapId& map,
                                            const PageRequest& page) const;
  // All of one kind, by id, whenever and for whatever robots they hold (areas::HoldsFor). One indexed query; none if
  // the map does not exist.
  absl::StatusOr<std::vector<MapArea>> ListOf(const CallContext& context, const SiteId& site, const MapId& map,
                                              areas::AreaKind kind) const;
  // Writes all but the ids. ABORTED on a stale `area.etag` (0: any); NOT_FOUND; INVALID_ARGUMENT and
  // FAILED_PRECONDITION as in Create.
  absl::StatusOr<MapArea> Update(const CallContext& context, const MapArea& area, bool force) const;
  // ABORTED on a stale `etag` (0: any); NOT_FOUND.
  absl::Status Delete(const CallContext& context, const SiteId& site, const MapId& map, const MapAreaId& id,
                      std::int64_t etag) const;

 private:
  postgres::Pool& pool_;
};

}  // namespace enfilade::storage
