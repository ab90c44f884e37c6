// SPDX-License-Identifier: Apache-2.0
#include "storage/sites/activity_store.h"

#include <algorithm>
#include <string_view>

#include "core/base/resource_name.h"
#include "storage/postgres/driver/rows.h"

namespace enfilade::storage {
namespace {

using postgres::Params;
using postgres::Result;
using postgres::Row;
using postgres::Statement;

constexpr Statement kSelectActivity{
    "reading the site",
    "SELECT s.create_time, clock_timestamp(), w.waiting, w.lag_s FROM enfilade.sites s, LATERAL ("
    "  SELECT count(*) AS waiting,"
    "    coalesce(extract(epoch FROM clock_timestamp() - min(waiting_since))::double precision, 0) AS lag_s"
    "  FROM enfilade.mapping_work WHERE site_id = $1) w WHERE s.site_id = $1 AND s.delete_time IS NULL"};
constexpr Statement kSelectCurrentRevisions{
    "reading the maps' revisions",
    "SELECT m.map_id, r.revision, r.create_time FROM enfilade.maps m JOIN enfilade.map_revisions r"
    " ON r.site_id = m.site_id AND r.map_id = m.map_id AND r.revision = m.current_revision"
    " WHERE m.site_id = $1 AND r.site_id = $1 ORDER BY m.map_id"};
#define ENFILADE_PROGRESS_COLUMNS                                                                         \
  "s.session_id, s.robot_id, s.map_id, s.state, s.acknowledged_sequence, coalesce(c.mapped_sequence, 0)," \
  " s.error, s.finish_time, s.delete_time IS NOT NULL FROM enfilade.sessions s"                           \
  " LEFT JOIN enfilade.mapping_checkpoints c ON c.site_id = s.site_id AND c.session_id = s.session_id"
// Each branch is a look at an index: sessions that are over are many.
constexpr Statement kSelectProgress{
    "reading the sessions' progress",
    "SELECT " ENFILADE_PROGRESS_COLUMNS
    " WHERE s.site_id = $1 AND s.session_id = ANY (ARRAY("
    "  SELECT o.session_id FROM enfilade.sessions o"
    "    WHERE o.site_id = $1 AND o.finish_time IS NULL AND o.delete_time IS NULL"
    "  UNION SELECT w.session_id FROM enfilade.mapping_work w WHERE w.site_id = $1"
    "  UNION SELECT e.session_id FROM enfilade.sessions e WHERE e.site_id = $1 AND e.delete_time IS NULL"
    "    AND e.finish_time >= $3 AND e.state IN (3, 4) AND NOT e.records_deleted"
    "  UNION SELECT unnest($2::text[]))) AND (s.delete_time IS NULL OR s.session_id = ANY ($2))"
    " ORDER BY s.session_id"};
constexpr Statement kSelectEnded{"reading the sessions that have ended",
                                 "SELECT " ENFILADE_PROGRESS_COLUMNS
                                 " WHERE s.site_id = $1 AND s.delete_time IS NULL AND s.finish_time >= $2"
                                 " AND s.state IN (3, 4) AND NOT s.records_deleted"
                                 " ORDER BY s.finish_time DESC LIMIT $3"};
// The trail outlives what it tells of.
constexpr Statement kSelectRemoved{
    "reading what was deleted",
    "SELECT DISTINCT l.resource FROM enfilade.audit_log l WHERE l.site_id = $1 AND l.audit_id >= $2 AND l.action = 3"
    " AND (starts_with(l.resource, 'sessions/') OR (starts_with(l.resource, 'robots/') AND NOT EXISTS ("
    "   SELECT FROM enfilade.robot_poses p WHERE p.site_id = $1 AND p.robot_id = substr(l.resource, 8))))"
    " ORDER BY l.resource"};

constexpr TimeNs kFarFuture = 9'000'000'000LL * kNsPerSecond;  // in the year 2255

SessionProgress ReadProgress(Row& row) {
  SessionProgress session;
  session.id = SessionId(std::string(row.Text()));
  session.robot = RobotId(std::string(row.OptionalText().value_or("")));
  if (const auto map = row.OptionalText()) session.map = MapId(std::string(*map));
  session.state = static_cast<SessionState>(row.Int16());
  session.acknowledged_sequence = row.Int64();
  session.mapped_sequence = row.Int64();
  session.error = row.OptionalText().value_or("");
  session.finish_time = row.OptionalTime();
  session.deleted = row.Bool();
  return session;
}

CurrentRevision ReadCurrentRevision(Row& row) {
  CurrentRevision revision;
  revision.map = MapId(std::string(row.Text()));
  revision.number = row.Int64();
  revision.create_time = row.Time();
  return revision;
}

SiteActivity ReadActivityRow(Row& row) {
  SiteActivity activity;
  activity.site_created = row.Time();
  activity.time = row.Time();
  activity.waiting_sessions = row.Int64();
  activity.mapping_lag_s = row.Double();
  return activity;
}

// The least id that enfilade.time_ordered_id() makes at `time`.
std::int64_t FirstIdAt(TimeNs time) {
  constexpr TimeNs kYear2020 = 1'577'836'800LL * kNsPerSecond;
  return std::max<TimeNs>(0, (time - kYear2020) / 1000) * 4096;
}

absl::StatusOr<PastActivity> ReadRemoved(const Result& result) {
  PastActivity past;
  for (int i = 0; i < result.rows(); ++i) {
    Row row(result, i);
    const std::string resource(row.Text());
    ENFILADE_RETURN_IF_ERROR(row.status());
    const std::string id = resource.substr(resource.find('/') + 1);
    if (resource.starts_with("robots/")) {
      past.removed_robots.emplace_back(id);
    } else {
      past.removed_sessions.emplace_back(id);
    }
  }
  return past;
}

}  // namespace

absl::StatusOr<SiteActivity> ActivityStore::Read(const CallContext& context, const SiteId& site,
                                                 const ActivityQuery& query) const {
  std::vector<std::string_view> ids;
  for (const SessionId& session : query.also) ids.push_back(session.value());
  ENFILADE_ASSIGN_OR_RETURN(auto transaction, postgres::Transaction::Begin(pool_, context));
  // The time first: what is committed after it has happened after it for those who read.
  transaction.Queue(kSelectActivity, Params(site));
  transaction.Queue(kSelectCurrentRevisions, Params(site));
  transaction.Queue(kSelectProgress,
                    Params(site, ids, postgres::Timestamp{query.since != 0 ? query.since : kFarFuture}));
  if (query.since != 0) transaction.Queue(kSelectRemoved, Params(site, FirstIdAt(query.since)));
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.FlushAndCommit());
  ENFILADE_ASSIGN_OR_RETURN(SiteActivity activity, postgres::ReadOne(results[0], ReadActivityRow, NameOf(site)));
  ENFILADE_ASSIGN_OR_RETURN(activity.revisions, postgres::ReadRows(results[1], ReadCurrentRevision));
  ENFILADE_ASSIGN_OR_RETURN(activity.sessions, postgres::ReadRows(results[2], ReadProgress));
  if (query.since != 0) {
    ENFILADE_ASSIGN_OR_RETURN(PastActivity removed, ReadRemoved(results[3]));
    activity.removed_sessions = std::move(removed.removed_sessions);
  }
  return activity;
}

absl::StatusOr<PastActivity> ActivityStore::ReadPast(const CallContext& context, const SiteId& site, TimeNs since,
                                                     TimeNs finished_since, int limit) const {
  ENFILADE_ASSIGN_OR_RETURN(auto transaction, postgres::Transaction::Begin(pool_, context));
  transaction.Queue(kSelectEnded, Params(site, postgres::Timestamp{finished_since}, std::int64_t{limit}));
  transaction.Queue(kSelectRemoved, Params(site, FirstIdAt(since)));
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.FlushAndCommit());
  ENFILADE_ASSIGN_OR_RETURN(PastActivity past, ReadRemoved(results[1]));
  ENFILADE_ASSIGN_OR_RETURN(past.ended, postgres::ReadRows(results[0], ReadProgress));
  std::sort(past.ended.begin(), past.ended.end(),
            [](const SessionProgress& a, const SessionProgress& b) { return a.id < b.id; });
  return past;
}

}  // namespace enfilade::storage
