// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "storage/postgres/driver/transaction.h"

namespace enfilade::storage::postgres {

// A deleted session of $1 whose other rows are still there, locked. Skips those that another process is purging.
extern const Statement kFindSessionToPurge;
// $1 site, $2 session: none of its obsolete rows are left.
extern const Statement kMarkSessionPurged;

// Deletes up to `limit` rows of a session: its records and, if `with_mapping`, what mapping has made of them. Returns
// how many; fewer than `limit`: none are left, which is recorded with the next flush.
absl::StatusOr<std::int64_t> PurgeSession(Transaction& transaction, const SiteId& site, const std::string& session,
                                          bool with_mapping, std::int64_t limit);

}  // namespace enfilade::storage::postgres
