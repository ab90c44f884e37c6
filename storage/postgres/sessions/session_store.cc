// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/sessions/session_store.h"

#include "core/base/resource_name.h"
#include "core/geometry/covariance.h"
#include "storage/postgres/driver/pose_columns.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/sessions/idle_sessions.h"
#include "storage/postgres/sessions/mapping_work.h"
#include "storage/postgres/sessions/session_deletion.h"
#include "storage/postgres/sessions/session_row.h"

namespace enfilade::storage::postgres {
namespace {

// The last piece of session `id`, which may have been cut.
#define ENFILADE_LAST_PIECE(id)                                                                    \
  "SELECT p.session_id FROM enfilade.sessions q JOIN enfilade.sessions p ON p.site_id = q.site_id" \
  " AND coalesce(q.cut_from_session_id, q.session_id) IN (p.session_id, p.cut_from_session_id)"    \
  " WHERE q.site_id = $1 AND q.session_id = " id " AND p.delete_time IS NULL ORDER BY p.skipped_records DESC LIMIT 1"
constexpr Statement kInsertSession{
    "creating the session",
    "INSERT INTO enfilade.sessions (site_id, session_id, robot_id, map_id, request_id, previous_session_id, initial_x,"
    " initial_y, initial_yaw, initial_covariance, initial_odom_x, initial_odom_y, initial_odom_yaw, request_sha256)"
    " SELECT $1, $2, $3, $4, $5, coalesce((" ENFILADE_LAST_PIECE("$6") "), $6), $7, $8, $9, $10, $11, $12, $13, $14"};
// So that it is not cut while the session that follows it is being created.
constexpr Statement kLockLastPiece{"locking the session before", ENFILADE_LAST_PIECE("$2") " FOR SHARE OF p"};
constexpr Statement kFindSessionRequest{
    "looking for an earlier request",
    "SELECT " ENFILADE_SESSION_COLUMNS ENFILADE_SAME_REQUEST(
        "$3") " FROM " ENFILADE_SESSION_TABLES " WHERE s.site_id = $1 AND s.request_id = $2 AND s.delete_time IS NULL"};
constexpr Statement kSelectSession{"reading the session",
                                   "SELECT " ENFILADE_SESSION_COLUMNS " FROM " ENFILADE_SESSION_TABLES
                                   " WHERE s.site_id = $1 AND s.session_id = $2 AND s.delete_time IS NULL"};
constexpr Statement kListSessions{
    "listing sessions",
    "SELECT " ENFILADE_SESSION_COLUMNS " FROM " ENFILADE_SESSION_TABLES
    " WHERE s.site_id = $1 AND s.delete_time IS NULL AND (s.create_time, s.session_id) < ($2, $3)"
    " AND ($4::text IS NULL OR s.robot_id = $4) AND ($5::text IS NULL OR s.map_id = $5)"
    " AND ($6::smallint IS NULL OR s.state = $6) ORDER BY s.create_time DESC, s.session_id DESC LIMIT $7"};
// A session that was cut since may still be told to finish: as far as it was recorded.
constexpr Statement kLockSession{
    "locking the session",
    "SELECT coalesce(recorded_sequence, acknowledged_sequence), coalesce(recorded_sequence, highest_sequence), "
    "finish_time"
    " FROM enfilade.sessions WHERE site_id = $1 AND session_id = $2 AND delete_time IS NULL FOR NO KEY UPDATE"};
// A session whose mapping has failed keeps its state.
constexpr Statement kFinish{
    "finishing the session",
    "UPDATE enfilade.sessions SET finish_time = now(), state = CASE WHEN state = 4 THEN 4"
    " WHEN map_id IS NULL AND previous_session_id IS NULL THEN 3 ELSE 2 END WHERE site_id = $1 AND session_id = $2"};

absl::Status Explain(const absl::Status& status, const Session& session) {
  if (absl::IsAlreadyExists(status)) {
    return AlreadyExists("{} exists already, or was deleted: choose another id", NameOf(session.site, session.id));
  }
  const std::string constraint = ConstraintOf(status);
  if (constraint == "sessions_site_id_fkey") return NotFound("{} does not exist", NameOf(session.site));
  if (constraint == "sessions_site_id_robot_id_fkey") {
    return NotFound("{} does not exist", NameOf(session.site, session.robot));
  }
  if (constraint == "sessions_site_id_map_id_fkey") {
    return NotFound("{} does not exist", NameOf(session.site, *session.map));
  }
  if (constraint == "sessions_site_id_previous_session_id_fkey") {
    return NotFound("{} does not exist", NameOf(session.site, *session.entry.previous));
  }
  return WithContext(status, NameOf(session.site, session.id));
}

absl::Status Insert(Pool& pool, const CallContext& context, const Session& session, const Params& values) {
  if (!session.entry.previous) return ExecuteAlone(pool, context, kInsertSession, values).status();
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool, context));
  transaction.Queue(kLockLastPiece, Params(session.site, *session.entry.previous));
  transaction.Queue(kInsertSession, values);
  return transaction.Commit();
}

}  // namespace

absl::StatusOr<Session> SessionStore::Create(const CallContext& context, const Session& session,
                                             const RequestId& request_id) const {
  const sensor::SessionEntry& entry = session.entry;
  if (entry.T_map_robot) {
    ENFILADE_RETURN_IF_ERROR(
        WithContext(ValidateMeasuredCovariance(entry.T_map_robot->covariance), "entry.pose_map_robot"));
  }
  const PoseColumns initial(entry.T_map_robot);
  const PoseColumns odom(entry.T_odom_robot);
  const Params values(session.site, session.id, session.robot, session.map, IdOrNull(request_id), entry.previous,
                      initial.x, initial.y, initial.yaw, initial.covariance, odom.x, odom.y, odom.yaw,
                      DigestOrNull(request_id));
  const absl::Status inserted = Insert(pool_, context, session, values);
  if (inserted.ok()) return Get(context, session.site, session.id);
  if (absl::IsAlreadyExists(inserted) && !request_id.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(const auto earlier,
                              ExecuteAlone(pool_, context, kFindSessionRequest,
                                           Params(session.site, request_id.value, DigestOrNull(request_id))));
    if (earlier.rows() > 0) return ReadRequested(earlier, ReadSession, NameOf(session.site, session.id));
  }
  return Explain(inserted, session);
}

absl::StatusOr<Session> SessionStore::Get(const CallContext& context, const SiteId& site,
                                          const SessionId& session) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result, ExecuteAlone(pool_, context, kSelectSession, Params(site, session)));
  return ReadOne(result, ReadSession, NameOf(site, session));
}

absl::StatusOr<std::vector<Session>> SessionStore::List(const CallContext& context, const SiteId& site,
                                                        const SessionFilter& filter, int limit,
                                                        const std::optional<SessionPosition>& after) const {
  constexpr TimeNs kLatest = 9'000'000'000LL * kNsPerSecond;  // in the year 2255
  const SessionPosition before = after.value_or(SessionPosition{kLatest, SessionId()});
  std::optional<std::int16_t> state;
  if (filter.state) state = static_cast<std::int16_t>(*filter.state);
  ENFILADE_ASSIGN_OR_RETURN(
      const auto result, ExecuteAlone(pool_, context, kListSessions,
                                      Params(site, Timestamp{before.create_time}, before.id, filter.robot, filter.map,
                                             state, static_cast<std::int64_t>(limit))));
  return ReadRows(result, ReadSession);
}

absl::StatusOr<Session> SessionStore::Finish(const CallContext& context, const SiteId& site, const SessionId& session,
                                             std::int64_t last_sequence) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_ASSIGN_OR_RETURN(const auto locked, transaction.Execute(kLockSession, Params(site, session)));
  if (locked.rows() == 0) return NotFound("{} does not exist", NameOf(site, session));
  Row row(locked, 0);
  const std::int64_t acknowledged = row.Int64();
  const std::int64_t highest = row.Int64();
  const bool finished = row.OptionalTime().has_value();
  ENFILADE_RETURN_IF_ERROR(row.status());
  if (highest != last_sequence) {
    return FailedPrecondition("{} cannot finish at record {}: the highest that is stored is {}", NameOf(site, session),
                              last_sequence, highest);
  }
  if (acknowledged != highest) {
    return FailedPrecondition("{} cannot finish: record {} is missing", NameOf(site, session), acknowledged + 1);
  }
  if (!finished) {
    transaction.Queue(kFinish, Params(site, session));
    QueueMappingWork(transaction, site, {session.value()});
  }
  transaction.Queue(kSelectSession, Params(site, session));
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.FlushAndCommit());
  return ReadOne(results.back(), ReadSession, NameOf(site, session));
}

absl::StatusOr<ClosedSessions> SessionStore::CloseIdle(const CallContext& context, std::chrono::seconds idle,
                                                       std::int64_t limit) const {
  return CloseIdleSessions(pool_, context, idle, limit);
}

absl::Status SessionStore::Delete(const CallContext& context, const SiteId& site, const SessionId& session) const {
  const std::vector<std::string_view> sessions = {session.value()};
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  transaction.Queue(kRevokeLeases, Params(site, sessions));
  ENFILADE_ASSIGN_OR_RETURN(const auto deleted, transaction.Execute(kMarkSessionsDeleted, Params(site, sessions)));
  if (deleted.rows() == 0) return NotFound("{} does not exist", NameOf(site, session));
  return WithContext(transaction.Commit(), NameOf(site, session));
}

}  // namespace enfilade::storage::postgres
