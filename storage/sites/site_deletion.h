// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "storage/call_context.h"

namespace enfilade::storage {
namespace postgres {
class Pool;
}

// A site that SiteStore::Delete has marked.
struct DeletedSite {
  SiteId id;
  std::string actor;  // who deletes it: the actor of the changes that DeletePortion makes
};

// Deletes what belongs to deleted sites, and at last the sites themselves, in small transactions. How far a deletion
// has come is in the database: another process can continue it at any moment. Thread-safe; errors common to all stores:
// see SiteStore.
class SiteDeletion {
 public:
  explicit SiteDeletion(postgres::Pool& pool) : pool_(pool) {}

  // The sites that are being deleted, by id.
  absl::StatusOr<std::vector<DeletedSite>> List(const CallContext& context) const;

  enum class Progress {
    kMore,   // there is more to delete
    kDone,   // the site is gone
    kTaken,  // another process is deleting a portion of it, or it is gone already
  };
  struct Portion {
    Progress progress = Progress::kMore;
    std::int64_t rows = 0;  // deleted
  };
  // Deletes up to `limit` rows of one kind. Locks are taken in the order lease, map, session.
  absl::StatusOr<Portion> DeletePortion(const CallContext& context, const SiteId& site, std::int64_t limit) const;

 private:
  postgres::Pool& pool_;
};

}  // namespace enfilade::storage
