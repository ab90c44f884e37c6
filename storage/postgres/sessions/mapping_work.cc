// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/sessions/mapping_work.h"

#include <algorithm>
#include <optional>

#include "core/base/resource_name.h"
#include "storage/postgres/driver/rows.h"

namespace enfilade::storage::postgres {
namespace {

// IsToBeMapped, of session `s` with its checkpoint `c`.
#define ENFILADE_TO_BE_MAPPED(read_sequence)                                                            \
  "(s.map_id IS NOT NULL AND s.state IN (1, 2) AND (s.state = 2 OR s.acknowledged_sequence > greatest(" \
  "coalesce(c.mapped_sequence, 0), " read_sequence ")))"
#define ENFILADE_QUEUE_WORK(waiting_since)                                                         \
  "INSERT INTO enfilade.mapping_work (site_id, session_id, waiting_since)"                         \
  " SELECT s.site_id, s.session_id, " waiting_since                                                \
  " FROM enfilade.sessions s LEFT JOIN enfilade.mapping_checkpoints c USING (site_id, session_id)" \
  " WHERE s.site_id = $1 AND " ENFILADE_TO_BE_MAPPED("0")

constexpr Statement kQueueWork{"queueing sessions for mapping",
                               ENFILADE_QUEUE_WORK("now()") " AND s.session_id = ANY ($2) ON CONFLICT DO NOTHING"};
constexpr Statement kQueueEntered{
    "queueing sessions for mapping",
    ENFILADE_QUEUE_WORK("s.create_time") " AND s.previous_session_id = $2 ON CONFLICT DO NOTHING"};
// Over all sites. The work it finds is then taken within its site.
constexpr Statement kFindWork{"looking for sessions to map",
                              "SELECT w.site_id, w.session_id FROM enfilade.mapping_work w"
                              " LEFT JOIN enfilade.session_leases l USING (site_id, session_id)"
                              " WHERE l.expires_at IS NULL OR l.expires_at <= clock_timestamp()"
                              " ORDER BY w.turn_time LIMIT $1"};
// Waits for whoever stores records or finishes the session, and makes them wait.
constexpr Statement kLockWork{"looking for records to map",
                              "SELECT " ENFILADE_TO_BE_MAPPED("$3") ", coalesce(c.mapped_sequence, 0)"
                              " FROM enfilade.sessions s LEFT JOIN enfilade.mapping_checkpoints c"
                              " USING (site_id, session_id)"
                              " WHERE s.site_id = $1 AND s.session_id = $2 FOR NO KEY UPDATE OF s"};
constexpr Statement kDropWork{"closing the session's turn",
                              "DELETE FROM enfilade.mapping_work WHERE site_id = $1 AND session_id = $2"};
// What still waits has come after $3, if that is set.
constexpr Statement kRequeueWork{
    "queueing the session for its next turn",
    "INSERT INTO enfilade.mapping_work AS w (site_id, session_id, waiting_since, turn_time)"
    " VALUES ($1, $2, coalesce($3, now()), now()) ON CONFLICT (site_id, session_id) DO UPDATE"
    " SET waiting_since = greatest(w.waiting_since, $3), turn_time = EXCLUDED.turn_time"};
constexpr Statement kSelectBacklog{
    "counting sessions to map",
    "SELECT b.count, b.oldest, u.count, u.oldest FROM"
    " (SELECT count(*), coalesce(extract(epoch FROM clock_timestamp() - min(waiting_since))::double precision, 0)"
    "   AS oldest FROM enfilade.mapping_work) b,"
    " (SELECT count(*), coalesce(extract(epoch FROM clock_timestamp() - min(p.finish_time))::double precision, 0)"
    "   AS oldest FROM enfilade.sessions n JOIN enfilade.sessions p"
    "   ON p.site_id = n.site_id AND p.session_id = n.previous_session_id WHERE n.previous_session_id IS NOT NULL"
    "   AND n.map_id IS NULL AND n.delete_time IS NULL AND p.finish_time IS NOT NULL) u"};

}  // namespace

void QueueMappingWork(Transaction& transaction, const SiteId& site, const std::vector<std::string_view>& sessions) {
  transaction.Queue(kQueueWork, Params(site, sessions));
}

void QueueEnteredSessions(Transaction& transaction, const SiteId& site, const SessionId& previous) {
  transaction.Queue(kQueueEntered, Params(site, previous));
}

absl::StatusOr<std::vector<WaitingSession>> FindMappingWork(Pool& pool, const CallContext& context) {
  ENFILADE_ASSIGN_OR_RETURN(const Result found, ExecuteAlone(pool, context, kFindWork,
                                                             Params(static_cast<std::int64_t>(kMappingCandidates))));
  return ReadRows(found, [](Row& row) {
    WaitingSession waiting;
    waiting.site = SiteId(std::string(row.Text()));
    waiting.session = SessionId(std::string(row.Text()));
    return waiting;
  });
}

void QueueWorkLock(Transaction& transaction, const SessionLease& lease, std::int64_t read_sequence) {
  transaction.Queue(kLockWork, Params(lease.site, lease.session, read_sequence));
}

absl::Status ReturnMappingWork(Transaction& transaction, const SessionLease& lease, std::int64_t read_sequence,
                               const Result& locked) {
  bool to_be_mapped = false;  // if the session no longer exists
  std::int64_t mapped_sequence = 0;
  if (locked.rows() > 0) {
    Row row(locked, 0);
    to_be_mapped = row.Bool();
    mapped_sequence = row.Int64();
    ENFILADE_RETURN_IF_ERROR(row.status());
  }
  if (!to_be_mapped) {
    transaction.Queue(kDropWork, Params(lease.site, lease.session));
    return absl::OkStatus();
  }
  std::optional<Timestamp> waiting_since;
  // What was read is mapped, even if it is not stored yet.
  if (std::max(mapped_sequence, read_sequence) >= lease.acknowledged_sequence)
    waiting_since = Timestamp{lease.take_time};
  transaction.Queue(kRequeueWork, Params(lease.site, lease.session, waiting_since));
  return absl::OkStatus();
}

absl::StatusOr<MappingBacklog> ReadMappingBacklog(Pool& pool, const CallContext& context) {
  ENFILADE_ASSIGN_OR_RETURN(const Result counted, ExecuteAlone(pool, context, kSelectBacklog, Params()));
  return ReadOne(
      counted,
      [](Row& row) {
        MappingBacklog backlog;
        backlog.sessions = row.Int64();
        backlog.oldest_s = row.Double();
        backlog.without_map = row.Int64();
        backlog.longest_without_map_s = row.Double();
        return backlog;
      },
      "the backlog of mapping");
}

}  // namespace enfilade::storage::postgres
