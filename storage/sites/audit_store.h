// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/base/time.h"
#include "storage/call_context.h"

namespace enfilade::storage {
namespace postgres {
class Pool;
}

// The numbers are in the database: never reuse one.
enum class AuditAction : std::int16_t { kCreated = 1, kUpdated = 2, kDeleted = 3 };

struct AuditEntry {
  std::int64_t id = 0;
  TimeNs time = 0;
  std::string actor;  // CallContext::actor of the call that changed it
  AuditAction action = AuditAction::kCreated;
  // robots/{robot}, maps/{map}, linkPoints/{link_point}/anchors/{map}, ...; empty: the site itself
  std::string resource;
  std::string before;  // the row as JSON; empty if it was created
  std::string after;   // empty if it was deleted
};

// Who changed a site, its robots, sessions, maps, imports or link points, and when. The database writes it in the
// transaction of the change. It outlives what it tells of. Thread-safe; errors common to all stores: see SiteStore.
class AuditStore {
 public:
  explicit AuditStore(postgres::Pool& pool) : pool_(pool) {}

  // Entries below `before` (0: all), newest first, of `resource` and its children (empty: of all resources).
  absl::StatusOr<std::vector<AuditEntry>> List(const CallContext& context, const SiteId& site,
                                               const std::string& resource, std::int64_t before, int limit) const;

 private:
  postgres::Pool& pool_;
};

}  // namespace enfilade::storage
