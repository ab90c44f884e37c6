// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/sessions/idle_sessions.h"

#include <string>
#include <string_view>
#include <vector>

#include "core/base/resource_name.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/driver/transaction.h"
#include "storage/postgres/sessions/mapping_work.h"

namespace enfilade::storage::postgres {
namespace {

#define ENFILADE_IS_IDLE(idle_s) \
  "finish_time IS NULL AND delete_time IS NULL AND append_time <= now() - " idle_s " * interval '1 second'"
// Sites are listed first and worked on one by one, so that an error in one of them leaves the others alone.
constexpr Statement kListIdle{"looking for idle sessions",
                              "SELECT DISTINCT site_id FROM enfilade.sessions"
                              " WHERE " ENFILADE_IS_IDLE("$1") " ORDER BY site_id"};
// Skips sessions that somebody is writing to.
constexpr Statement kLockIdle{"looking for idle sessions",
                              "SELECT session_id FROM enfilade.sessions WHERE site_id = $1 AND " ENFILADE_IS_IDLE(
                                  "$2") " ORDER BY session_id LIMIT $3 FOR NO KEY UPDATE SKIP LOCKED"};
constexpr Statement kClose{
    "closing idle sessions",
    "UPDATE enfilade.sessions SET finish_time = now(),"
    " state = CASE WHEN state = 4 OR acknowledged_sequence < highest_sequence THEN 4"
    "   WHEN map_id IS NULL AND previous_session_id IS NULL THEN 3 ELSE 2 END,"
    " error = CASE WHEN state = 4 OR acknowledged_sequence = highest_sequence THEN error"
    "   ELSE 'nothing came for ' || $3 || ' s, and record ' || acknowledged_sequence + 1 || ' is missing' END"
    " WHERE site_id = $1 AND session_id = ANY ($2) RETURNING state"};

absl::StatusOr<ClosedSessions> CloseInSite(Pool& pool, const CallContext& context, const SiteId& site,
                                           std::chrono::seconds idle, std::int64_t limit) {
  const auto idle_s = static_cast<std::int64_t>(idle.count());
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool, context));
  ENFILADE_ASSIGN_OR_RETURN(const Result locked, transaction.Execute(kLockIdle, Params(site, idle_s, limit)));
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<std::string> ids,
                            ReadRows(locked, [](Row& row) { return std::string(row.Text()); }));
  const std::vector<std::string_view> sessions(ids.begin(), ids.end());
  const std::string idle_text = std::to_string(idle_s);
  transaction.Queue(kClose, Params(site, sessions, idle_text));
  QueueMappingWork(transaction, site, sessions);
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.FlushAndCommit());
  ENFILADE_ASSIGN_OR_RETURN(const auto states,
                            ReadRows(results[0], [](Row& row) { return static_cast<SessionState>(row.Int16()); }));
  ClosedSessions closed;
  for (const SessionState state : states) ++(state == SessionState::kFailed ? closed.failed : closed.finished);
  return closed;
}

}  // namespace

absl::StatusOr<ClosedSessions> CloseIdleSessions(Pool& pool, const CallContext& context, std::chrono::seconds idle,
                                                 std::int64_t limit) {
  ENFILADE_ASSIGN_OR_RETURN(const Result listed,
                            ExecuteAlone(pool, context, kListIdle, Params(static_cast<std::int64_t>(idle.count()))));
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<SiteId> sites,
                            ReadRows(listed, [](Row& row) { return SiteId(std::string(row.Text())); }));
  ClosedSessions total;
  absl::Status error;
  for (const SiteId& site : sites) {
    const std::int64_t left = limit - total.finished - total.failed;
    if (left <= 0) break;
    const auto closed = CloseInSite(pool, context, site, idle, left);
    if (closed.ok()) {
      total.finished += closed->finished;
      total.failed += closed->failed;
    } else {
      error.Update(WithContext(closed.status(), NameOf(site)));
    }
  }
  if (total.finished + total.failed == 0 && !error.ok()) return error;
  return total;
}

}  // namespace enfilade::storage::postgres
