// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "storage/maps/map_store.h"
#include "storage/postgres/driver/pool.h"

namespace enfilade::storage::postgres {

class MapStore final : public storage::MapStore {
 public:
  explicit MapStore(Pool& pool) : pool_(pool) {}

  absl::StatusOr<Map> Create(const CallContext& context, const Map& map, const RequestId& request_id) const override;
  absl::StatusOr<Map> Get(const CallContext& context, const SiteId& site, const MapId& map) const override;
  absl::StatusOr<Map> GetByDisplayName(const CallContext& context, const SiteId& site,
                                       const std::string& display_name) const override;
  absl::StatusOr<std::vector<Map>> List(const CallContext& context, const SiteId& site,
                                        const PageRequest& page) const override;
  absl::StatusOr<Map> Update(const CallContext& context, const Map& map) const override;
  absl::Status Delete(const CallContext& context, const SiteId& site, const MapId& map, std::int64_t etag,
                      bool force) const override;

 private:
  Pool& pool_;
};

}  // namespace enfilade::storage::postgres
