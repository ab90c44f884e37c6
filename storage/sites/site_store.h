// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/base/time.h"
#include "storage/call_context.h"
#include "storage/request_id.h"

namespace enfilade::storage {
namespace postgres {
class Pool;
}

// A hundred years.
constexpr std::chrono::seconds kMaxRetention = std::chrono::hours(24) * 36'500;

// Which revisions of a map are kept. Its current revision is, and those that have a tag or are layers of the map.
struct RevisionRetention {
  int newest = 1;                                // so many of each map, at least 1
  std::optional<std::chrono::seconds> age = {};  // and those made since, 0 to kMaxRetention; unset: no others
};

// A campus: a tenant of the server.
struct Site {
  // Of a site that is being deleted, in the background.
  struct Deletion {
    TimeNs time = 0;                // when it began
    std::string actor;              // CallContext::actor of the call that began it
    std::int64_t deleted_rows = 0;  // so far
  };

  SiteId id;
  std::string display_name;
  // How long the records of a session are kept after it has finished, 0 to kMaxRetention; unset: for ever.
  std::optional<std::chrono::seconds> raw_retention = {};
  // How long a session is kept after it has finished, 0 to kMaxRetention; unset: for ever. What it saw stays in its
  // map.
  std::optional<std::chrono::seconds> session_retention = {};
  std::optional<RevisionRetention> revision_retention = {};  // unset: all are kept
  // How long versions of the graph and what was removed from it, and entries of the audit trail are kept, 0 to
  // kMaxRetention; unset: for ever.
  std::optional<std::chrono::seconds> history_retention = {};
  std::optional<std::chrono::seconds> audit_retention = {};
  // Set by the store. A new value with every change, never used twice.
  std::int64_t etag = 0;
  TimeNs create_time = 0;
  TimeNs update_time = 0;
  std::optional<Deletion> deletion = {};
};

// Thread-safe. Errors common to all stores: UNAVAILABLE if the database cannot be reached or the outcome of a commit is
// unknown (retrying is safe); DEADLINE_EXCEEDED past the context's deadline; INVALID_ARGUMENT if a constraint of the
// schema is violated, naming it.
class SiteStore {
 public:
  explicit SiteStore(postgres::Pool& pool) : pool_(pool) {}

  // ALREADY_EXISTS if the id is taken; FAILED_PRECONDITION if the site that has it is being deleted. If an earlier call
  // with the same `request_id` (AIP-155; empty: none) has created a site, returns that site and creates nothing.
  absl::StatusOr<Site> Create(const CallContext& context, const Site& site, const RequestId& request_id) const;
  // NOT_FOUND.
  absl::StatusOr<Site> Get(const CallContext& context, const SiteId& site) const;
  // By id.
  absl::StatusOr<std::vector<Site>> List(const CallContext& context, const PageRequest& page) const;
  // Writes display name and retentions. ABORTED if `site.etag` is not the stored one; FAILED_PRECONDITION if it is
  // being deleted; NOT_FOUND.
  absl::StatusOr<Site> Update(const CallContext& context, const Site& site) const;
  // Marks the site as deleted: from now on nothing can be added to it. SiteDeletion deletes it. Returns the site; one
  // that is being deleted already as it is. ABORTED if `etag` (0: any) is not the stored one; FAILED_PRECONDITION if
  // the site has maps, robots or sessions, unless `force`, which deletes all of them; NOT_FOUND.
  absl::StatusOr<Site> Delete(const CallContext& context, const SiteId& site, std::int64_t etag, bool force) const;

 private:
  postgres::Pool& pool_;
};

}  // namespace enfilade::storage
