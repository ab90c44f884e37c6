// SPDX-License-Identifier: Apache-2.0
#include "storage/sessions/loop_closure_store.h"

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/sessions/mapping_work.h"
#include "storage/postgres/sessions/session_row.h"
#include "storage/postgres/sessions/slam_rows.h"

namespace enfilade::storage {
namespace {

using postgres::ExecuteAlone;
using postgres::Params;
using postgres::Row;
using postgres::Statement;
using postgres::Transaction;

constexpr Statement kListLoopClosures{"listing closures",
                                      "SELECT " ENFILADE_LOOP_CLOSURE_COLUMNS
                                      " FROM enfilade.slam_closures WHERE site_id = $1 AND session_id = $2"
                                      " AND closure_id > $3 ORDER BY closure_id LIMIT $4"};
constexpr Statement kSelectLoopClosure{
    "reading the closure", "SELECT " ENFILADE_LOOP_CLOSURE_COLUMNS
                           " FROM enfilade.slam_closures WHERE site_id = $1 AND session_id = $2 AND closure_id = $3"};
// The next commit of the holder fails, and the next holder reads the new state.
constexpr Statement kRevokeLease{"revoking the lease",
                                 "INSERT INTO enfilade.session_leases AS l"
                                 " (site_id, session_id, owner, token, expires_at)"
                                 " VALUES ($1, $2, '', 1, clock_timestamp())"
                                 " ON CONFLICT (site_id, session_id) DO UPDATE SET owner = '', token = l.token + 1,"
                                 " attempts = 0, expires_at = EXCLUDED.expires_at"};
// What was cut cannot be solved again: its checkpoint belongs to the whole.
constexpr Statement kFindCut{"looking for a cut",
                             "SELECT true FROM enfilade.sessions WHERE site_id = $1 AND session_id = $2"
                             " AND recorded_sequence IS NOT NULL"};
constexpr Statement kSetLoopClosureState{"changing the closure's state",
                                         "UPDATE enfilade.slam_closures SET state = $4"
                                         " WHERE site_id = $1 AND session_id = $2 AND closure_id = $3"
                                         " RETURNING " ENFILADE_LOOP_CLOSURE_COLUMNS};
constexpr Statement kReopen{"opening the session for mapping",
                            "UPDATE enfilade.sessions SET state = 2"
                            " WHERE site_id = $1 AND session_id = $2 AND state = 3 AND delete_time IS NULL"};

std::string LoopClosureName(const SiteId& site, const SessionId& session, std::int64_t closure) {
  return fmt::format("{}/closures/{}", NameOf(site, session), closure);
}

}  // namespace

absl::StatusOr<std::vector<slam::LoopClosure>> LoopClosureStore::List(const CallContext& context, const SiteId& site,
                                                                      const SessionId& session, std::int64_t after,
                                                                      int limit) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  transaction.Queue(postgres::kSessionExists, Params(site, session));
  transaction.Queue(kListLoopClosures, Params(site, session, after, std::int64_t{limit}));
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.FlushAndCommit());
  if (results[0].rows() == 0) return NotFound("{} does not exist", NameOf(site, session));
  return storage::postgres::ReadRows(results[1], postgres::ReadLoopClosure);
}

absl::StatusOr<slam::LoopClosure> LoopClosureStore::SetSuspended(const CallContext& context, const SiteId& site,
                                                                 const SessionId& session, std::int64_t closure,
                                                                 bool suspended) const {
  const std::string name = LoopClosureName(site, session, closure);
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  transaction.Queue(kRevokeLease, Params(site, session));
  transaction.Queue(kSelectLoopClosure, Params(site, session, closure));
  const auto locked = transaction.Flush();
  // The foreign key of the lease's row.
  if (!locked.ok() && absl::IsFailedPrecondition(locked.status())) return NotFound("{} does not exist", name);
  ENFILADE_RETURN_IF_ERROR(locked.status());
  ENFILADE_ASSIGN_OR_RETURN(const slam::LoopClosure stored,
                            storage::postgres::ReadOne((*locked)[1], postgres::ReadLoopClosure, name));
  if ((stored.state == slam::LoopClosureState::kSuspended) == suspended)
    return stored;  // the revocation is rolled back
  ENFILADE_ASSIGN_OR_RETURN(const auto cut, transaction.Execute(kFindCut, Params(site, session)));
  if (cut.rows() > 0) {
    return FailedPrecondition("{} was cut in two: its map is not solved again. Undo the cut first",
                              NameOf(site, session));
  }
  const slam::LoopClosureState state =
      suspended ? slam::LoopClosureState::kSuspended : slam::LoopClosureState::kAccepted;
  transaction.Queue(kSetLoopClosureState, Params(site, session, closure, static_cast<std::int16_t>(state)));
  transaction.Queue(kReopen, Params(site, session));
  postgres::QueueMappingWork(transaction, site, {session.value()});
  ENFILADE_ASSIGN_OR_RETURN(const auto changed, transaction.FlushAndCommit());
  return storage::postgres::ReadOne(changed[0], postgres::ReadLoopClosure, name);
}

}  // namespace enfilade::storage
