// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/environment.h"
#include "core/base/ids.h"
#include "core/base/time.h"
#include "storage/call_context.h"

namespace enfilade::storage {
namespace postgres {
class Pool;
}

// The numbers of these enums are in the database: never reuse one.
enum class MapState : std::int16_t {
  kEmpty = 1,    // no revision yet
  kMapping = 2,  // more revisions of the same session will come
  kReady = 3,
};

struct Map {
  SiteId site;
  MapId id;
  std::string display_name;  // 1 to 200 characters, unique in its site
  int level = 0;             // the floor
  Environment environment = Environment::kIndoor;
  std::string slam_profile;
  std::vector<Eigen::Vector2d>
      outline;  // m, map frame; a simple polygon without the repeated last corner; may be empty
  // Set by the store.
  MapState state = MapState::kEmpty;
  std::int64_t current_revision = 0;  // 0: none
  std::int64_t etag = 0;
  TimeNs create_time = 0;
  TimeNs update_time = 0;
};

// An axis-aligned rectangle in a map's frame, m.
struct Rectangle {
  Eigen::Vector2d min;
  Eigen::Vector2d max;
};

// Every change raises the version of the site's graph. Thread-safe; errors common to all stores: see SiteStore.
class MapStore {
 public:
  explicit MapStore(postgres::Pool& pool) : pool_(pool) {}

  // ALREADY_EXISTS where id or display name are taken (the message says which); NOT_FOUND where the site is missing.
  // `request_id` as in SiteStore.
  absl::StatusOr<Map> Create(const CallContext& context, const Map& map, const std::string& request_id) const;
  absl::StatusOr<Map> Get(const CallContext& context, const SiteId& site, const MapId& map) const;
  // NOT_FOUND where no map of the site has that name.
  absl::StatusOr<Map> GetByDisplayName(const CallContext& context, const SiteId& site,
                                       const std::string& display_name) const;
  absl::StatusOr<std::vector<Map>> List(const CallContext& context, const SiteId& site, const PageRequest& page) const;
  // The maps of one level whose outline meets `rectangle`, by id; indexed.
  absl::StatusOr<std::vector<Map>> FindByOutline(const CallContext& context, const SiteId& site, int level,
                                                 const Rectangle& rectangle) const;
  // Writes display name, level, environment, profile and outline. ABORTED on a stale `map.etag`, NOT_FOUND,
  // ALREADY_EXISTS where the display name is taken. A new revision leaves the etag as it is.
  absl::StatusOr<Map> Update(const CallContext& context, const Map& map) const;
  // With its revisions. FAILED_PRECONDITION naming the sessions that map into it and the link points that join it,
  // unless `force`, which deletes them; a link point that joins two other maps only loses its anchor here.
  // ABORTED on a stale `etag` (0: any); NOT_FOUND.
  absl::Status Delete(const CallContext& context, const SiteId& site, const MapId& map, std::int64_t etag,
                      bool force) const;

 private:
  postgres::Pool& pool_;
};

}  // namespace enfilade::storage
