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
#include "storage/request_id.h"

namespace enfilade::storage {
// The numbers of these enums are in the database: never reuse one.
enum class MapState : std::int16_t {
  kEmpty = 1,    // no revision yet
  kMapping = 2,  // the session of the current revision is still being mapped
  kReady = 3,
};

struct Map {
  SiteId site;
  MapId id;
  std::string display_name;  // 1 to 200 characters, unique in its site
  int level = 0;             // the floor
  Environment environment = Environment::kIndoor;
  std::string slam_profile;
  // m, map frame: a simple polygon without the repeated last corner; may be empty.
  std::vector<Eigen::Vector2d> outline;
  bool pinned = false;  // people have decided which sessions it has: surveys take none out of it
  // Set by the store.
  MapState state = MapState::kEmpty;
  std::int64_t current_revision = 0;  // 0: none
  std::int64_t etag = 0;
  TimeNs create_time = 0;
  TimeNs update_time = 0;
};

// INVALID_ARGUMENT if a corner is not finite or there are one or two. That the sides do not cross is up to the store.
absl::Status ValidateOutline(const Map& map);

// What refers to a map, by id.
struct MapUse {
  std::vector<std::string> sessions;
  std::vector<std::string> link_points;
};
// FAILED_PRECONDITION naming what refers to it.
absl::Status ValidateUnused(const SiteId& site, const MapId& map, const MapUse& use);

// Read access to maps. Thread-safe; errors common to all stores: see SiteStore.
class MapReader {
 public:
  virtual ~MapReader() = default;

  // NOT_FOUND.
  virtual absl::StatusOr<Map> Get(const CallContext& context, const SiteId& site, const MapId& map) const = 0;
  // NOT_FOUND if no map of the site has that name.
  virtual absl::StatusOr<Map> GetByDisplayName(const CallContext& context, const SiteId& site,
                                               const std::string& display_name) const = 0;
  // By id.
  virtual absl::StatusOr<std::vector<Map>> List(const CallContext& context, const SiteId& site,
                                                const PageRequest& page) const = 0;
};

// Every change raises the version of the site's graph. Thread-safe; errors common to all stores: see SiteStore.
class MapStore : public MapReader {
 public:
  // ALREADY_EXISTS naming whether the id or the display name is taken; NOT_FOUND if the site does not exist;
  // INVALID_ARGUMENT if the outline is not a simple polygon. `request_id` as in SiteStore.
  virtual absl::StatusOr<Map> Create(const CallContext& context, const Map& map, const RequestId& request_id) const = 0;
  // Writes display name, level, environment, profile and outline. ABORTED on a stale `map.etag`; NOT_FOUND;
  // ALREADY_EXISTS if the display name is taken; INVALID_ARGUMENT as in Create. A new revision keeps the etag.
  virtual absl::StatusOr<Map> Update(const CallContext& context, const Map& map) const = 0;
  // Deletes its revisions, too. FAILED_PRECONDITION naming the sessions that map into it and the link points that join
  // it, unless `force`, which deletes them; a link point that joins two other maps only loses its anchor here.
  // ABORTED on a stale `etag` (0: any); NOT_FOUND.
  virtual absl::Status Delete(const CallContext& context, const SiteId& site, const MapId& map, std::int64_t etag,
                              bool force) const = 0;
};

}  // namespace enfilade::storage
