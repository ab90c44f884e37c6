// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/sessions/session_purge.h"

#include <array>

#include "core/base/status_macros.h"
#include "storage/postgres/driver/delete_portion.h"

namespace enfilade::storage::postgres {
namespace {

#define ENFILADE_PURGE(table) ENFILADE_DELETE_PORTION(table, "session_id = $2", "$3")
// First what retention deletes, then what only the session's deletion does, in an order that foreign keys permit.
constexpr std::array kTables = {
    ENFILADE_PURGE("session_record_blobs"), ENFILADE_PURGE("session_records"), ENFILADE_PURGE("door_comparisons"),
    ENFILADE_PURGE("door_verdicts"),        ENFILADE_PURGE("session_tracks"),  ENFILADE_PURGE("trajectory_points"),
    ENFILADE_PURGE("slam_closures"),        ENFILADE_PURGE("slam_nodes"),      ENFILADE_PURGE("slam_submaps"),
    ENFILADE_PURGE("mapping_checkpoints"),  ENFILADE_PURGE("session_leases"),  ENFILADE_PURGE("mapping_work"),
};
constexpr std::size_t kRecordTables = 2;
#undef ENFILADE_PURGE

}  // namespace

const Statement kFindSessionToPurge{"looking for a deleted session",
                                    "SELECT session_id FROM enfilade.sessions WHERE site_id = $1"
                                    " AND delete_time IS NOT NULL AND NOT purged LIMIT 1 FOR UPDATE SKIP LOCKED"};
// A deleted session refers to no other, so that those before it can be forgotten.
const Statement kMarkSessionPurged{"closing the session",
                                   "UPDATE enfilade.sessions SET purged = true,"
                                   " previous_session_id = CASE WHEN delete_time IS NULL THEN previous_session_id END,"
                                   " cut_from_session_id = CASE WHEN delete_time IS NULL THEN cut_from_session_id END"
                                   " WHERE site_id = $1 AND session_id = $2"};

absl::StatusOr<std::int64_t> PurgeSession(Transaction& transaction, const SiteId& site, const std::string& session,
                                          bool with_mapping, std::int64_t limit) {
  std::int64_t deleted = 0;
  const std::size_t tables = with_mapping ? kTables.size() : kRecordTables;
  for (std::size_t table = 0; table < tables && deleted < limit; ++table) {
    ENFILADE_ASSIGN_OR_RETURN(const Result result,
                              transaction.Execute(kTables[table], Params(site, session, limit - deleted)));
    deleted += result.affected();
  }
  if (deleted < limit) transaction.Queue(kMarkSessionPurged, Params(site, session));
  return deleted;
}

}  // namespace enfilade::storage::postgres
