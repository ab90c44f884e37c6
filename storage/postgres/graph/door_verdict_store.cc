// SPDX-License-Identifier: Apache-2.0
#include "storage/graph/door_verdict_store.h"

#include "core/base/resource_name.h"
#include "core/sensor/record_codec.h"
#include "storage/postgres/driver/pose_columns.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/graph/door_verdict_rows.h"
#include "storage/postgres/graph/graph_versions.h"
#include "storage/postgres/graph/link_point_changes.h"
#include "storage/postgres/graph/link_point_evidence.h"
#include "storage/postgres/graph/site_locks.h"
#include "storage/postgres/maps/numbered_map.h"
#include "storage/postgres/sessions/mapping_work.h"
#include "storage/postgres/sessions/session_row.h"

namespace enfilade::storage {
namespace {

using postgres::ExecuteAlone;
using postgres::Params;
using postgres::PoseColumns;
using postgres::Row;
using postgres::Statement;
using postgres::Transaction;

constexpr std::int16_t kDoorReport = static_cast<std::int16_t>(sensor::RecordKind::kDoorReport);
static_assert(kDoorReport == 6);  // of the index session_records_doors_idx

// Reads over all sites, as session_leases.cc does. The work it finds is then done within its site.
constexpr Statement kFindPending{
    "looking for doors to judge",
    "SELECT site_id, session_id FROM ("
    "  SELECT w.*, row_number() OVER (PARTITION BY site_id ORDER BY finish_time NULLS FIRST, session_id) AS turn FROM ("
    "    SELECT site_id, session_id, finish_time FROM enfilade.sessions WHERE door_reports > 0 AND NOT doors_judged"
    "      AND state IN (3, 4) AND finish_time IS NOT NULL AND delete_time IS NULL"
    "    UNION SELECT p.site_id, p.session_id, p.finish_time FROM enfilade.sessions n JOIN enfilade.sessions p"
    "      ON p.site_id = n.site_id AND p.session_id = n.previous_session_id"
    "      WHERE n.previous_session_id IS NOT NULL AND n.map_id IS NULL AND n.delete_time IS NULL"
    "      AND (p.delete_time IS NOT NULL OR (p.state IN (3, 4) AND p.finish_time IS NOT NULL))) w"
    "  WHERE NOT EXISTS (SELECT FROM unnest($2::text[], $3::text[]) AS d (site_id, session_id)"
    "    WHERE d.site_id = w.site_id AND d.session_id = w.session_id)"
    "  AND NOT w.site_id = ANY ($4::text[])) ranked"
    " ORDER BY turn, site_id, session_id LIMIT $1"};
constexpr Statement kReadReports{"reading door reports",
                                 "SELECT r.sequence, r.payload, v.sequence IS NOT NULL, v.odom_x, v.odom_y, v.odom_yaw"
                                 " FROM enfilade.session_records r"
                                 " LEFT JOIN enfilade.door_verdicts v USING (site_id, session_id, sequence)"
                                 " WHERE r.site_id = $1 AND r.session_id = $2 AND r.kind = 6 ORDER BY r.sequence"};
constexpr Statement kListCandidateReports{
    "reading candidates' reports",
    "SELECT v.link_point_id, v.session_id, r.sequence, r.payload FROM enfilade.door_verdicts v"
    " JOIN enfilade.link_points l USING (site_id, link_point_id)"
    " JOIN enfilade.session_records r USING (site_id, session_id, sequence)"
    " WHERE v.site_id = $1 AND v.decision = 1 AND r.kind = 6 ORDER BY v.link_point_id"};
static_assert(static_cast<int>(closure::DoorDecision::kCandidateMade) == 1);
constexpr Statement kListWaiting{"looking for sessions that wait",
                                 "SELECT session_id FROM enfilade.sessions WHERE site_id = $1"
                                 " AND previous_session_id = $2 AND map_id IS NULL AND delete_time IS NULL"
                                 " ORDER BY create_time, session_id"};
constexpr Statement kIsJudged{
    "looking for the verdict",
    "SELECT true FROM enfilade.door_verdicts WHERE site_id = $1 AND session_id = $2 AND sequence = $3"};
constexpr Statement kEnter{
    "giving the next session its map",
    "UPDATE enfilade.sessions SET map_id = $3, initial_x = $4, initial_y = $5, initial_yaw = $6,"
    " initial_covariance = $7, initial_odom_x = $8, initial_odom_y = $9, initial_odom_yaw = $10"
    " WHERE site_id = $1 AND previous_session_id = $2 AND map_id IS NULL AND delete_time IS NULL"};
constexpr Statement kMarkJudged{"closing the session's doors",
                                "UPDATE enfilade.sessions SET doors_judged = true"
                                " WHERE site_id = $1 AND session_id = $2"};
constexpr Statement kListVerdicts{"listing verdicts",
                                  "SELECT " ENFILADE_VERDICT_COLUMNS
                                  " FROM enfilade.door_verdicts WHERE site_id = $1 AND session_id = $2"
                                  " AND sequence > $3 ORDER BY sequence LIMIT $4"};
constexpr Statement kFindPassage{"looking for the verdict on the passage",
                                 "SELECT " ENFILADE_VERDICT_COLUMNS
                                 " FROM enfilade.door_verdicts WHERE site_id = $1 AND session_id = $2"
                                 " AND map_id IS NOT NULL ORDER BY sequence DESC LIMIT 1"};
constexpr Statement kListInto{"listing verdicts on passages into a map",
                              "SELECT " ENFILADE_VERDICT_COLUMNS
                              " FROM enfilade.door_verdicts WHERE site_id = $1 AND map_id = $2"
                              " ORDER BY create_time DESC, session_id, sequence LIMIT $3"};
constexpr Statement kListComparisons{
    "listing comparisons",
    "SELECT sequence, link_point_id, map_id, distance, image_matches::bigint, images_agree, rmse, inlier_share,"
    " clouds_agree, chi2, accepted, reason FROM enfilade.door_comparisons WHERE site_id = $1 AND session_id = $2"
    " AND sequence BETWEEN $3 AND $4 ORDER BY sequence, ordinal"};

absl::StatusOr<sensor::DoorReport> DecodeReport(std::int64_t sequence, std::string_view payload, const SiteId& site,
                                                const SessionId& session) {
  auto record = sensor::DecodePayload(sequence, sensor::RecordKind::kDoorReport, payload);
  if (!record.ok()) return WithContext(record.status(), NameOf(site, session));
  return std::get<sensor::DoorReport>(std::move(record->payload));
}

absl::Status ChangeLinkPoints(Transaction& transaction, const SiteId& site, const DoorChange& change) {
  for (const LinkPointId& candidate : change.consumed) {
    ENFILADE_RETURN_IF_ERROR(postgres::RemoveLinkPoint(transaction, site, candidate, 0));
  }
  if (change.new_link_point) {
    ENFILADE_RETURN_IF_ERROR(postgres::InsertLinkPoint(transaction, *change.new_link_point, ""));
  }
  if (change.link_point) ENFILADE_RETURN_IF_ERROR(postgres::UpdateLinkPoint(transaction, *change.link_point));
  return absl::OkStatus();
}

void QueueEntry(Transaction& transaction, const SiteId& site, const EnteredMap& entered) {
  const PoseColumns pose(entered.T_map_robot), odom(entered.T_odom_robot);
  transaction.Queue(kEnter, Params(site, entered.previous, entered.map, pose.x, pose.y, pose.yaw, pose.covariance,
                                   odom.x, odom.y, odom.yaw));
  postgres::QueueEnteredSessions(transaction, site, entered.previous);
}

}  // namespace

absl::StatusOr<std::vector<PendingDoors>> DoorVerdictStore::FindPending(const CallContext& context, int limit,
                                                                        const PostponedDoors& postponed) const {
  std::vector<std::string_view> sites, sessions, whole_sites;
  for (const PendingDoors& doors : postponed.sessions) {
    sites.push_back(doors.site.value());
    sessions.push_back(doors.session.value());
  }
  for (const SiteId& site : postponed.sites) whole_sites.push_back(site.value());
  ENFILADE_ASSIGN_OR_RETURN(const auto result,
                            storage::postgres::ExecuteAlone(pool_, context, kFindPending,
                                                            Params(std::int64_t{limit}, sites, sessions, whole_sites)));
  return storage::postgres::ReadRows(result, [](Row& row) {
    PendingDoors pending;
    pending.site = SiteId(std::string(row.Text()));
    pending.session = SessionId(std::string(row.Text()));
    return pending;
  });
}

absl::StatusOr<std::vector<StoredDoorReport>> DoorVerdictStore::ReadReports(const CallContext& context,
                                                                            const SiteId& site,
                                                                            const SessionId& session) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result,
                            storage::postgres::ExecuteAlone(pool_, context, kReadReports, Params(site, session)));
  std::vector<StoredDoorReport> reports;
  for (int i = 0; i < result.rows(); ++i) {
    Row row(result, i);
    StoredDoorReport stored;
    stored.sequence = row.Int64();
    const std::string_view payload = row.Bytes();
    stored.judged = row.Bool();
    stored.T_odom_robot = postgres::ReadOptionalPose(row);
    ENFILADE_RETURN_IF_ERROR(row.status());
    ENFILADE_ASSIGN_OR_RETURN(stored.report, DecodeReport(stored.sequence, payload, site, session));
    reports.push_back(std::move(stored));
  }
  return reports;
}

absl::StatusOr<std::vector<CandidateReport>> DoorVerdictStore::ListCandidateReports(const CallContext& context,
                                                                                    const SiteId& site) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result,
                            storage::postgres::ExecuteAlone(pool_, context, kListCandidateReports, Params(site)));
  std::vector<CandidateReport> reports;
  for (int i = 0; i < result.rows(); ++i) {
    Row row(result, i);
    CandidateReport one;
    one.candidate = LinkPointId(std::string(row.Text()));
    const SessionId session{std::string(row.Text())};
    const std::int64_t sequence = row.Int64();
    const std::string_view payload = row.Bytes();
    ENFILADE_RETURN_IF_ERROR(row.status());
    ENFILADE_ASSIGN_OR_RETURN(one.report, DecodeReport(sequence, payload, site, session));
    reports.push_back(std::move(one));
  }
  return reports;
}

absl::StatusOr<std::vector<SessionId>> DoorVerdictStore::ListWaiting(const CallContext& context, const SiteId& site,
                                                                     const SessionId& previous) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result,
                            storage::postgres::ExecuteAlone(pool_, context, kListWaiting, Params(site, previous)));
  return storage::postgres::ReadRows(result, [](Row& row) { return SessionId(std::string(row.Text())); });
}

absl::Status DoorVerdictStore::Commit(const CallContext& context, const SiteLease& lease,
                                      const DoorChange& change) const {
  const SiteId& site = lease.site;
  const closure::DoorVerdict& verdict = change.verdict;
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_ASSIGN_OR_RETURN(const auto judged,
                            transaction.Execute(kIsJudged, Params(site, verdict.session, verdict.sequence)));
  if (judged.rows() > 0) return absl::OkStatus();
  ENFILADE_RETURN_IF_ERROR(postgres::LockGraphAt(transaction, site, verdict.graph_version));
  ENFILADE_RETURN_IF_ERROR(postgres::LockSiteLease(transaction, lease));
  if (change.new_map) postgres::QueueNumberedMap(transaction, site, *change.new_map);
  ENFILADE_RETURN_IF_ERROR(ChangeLinkPoints(transaction, site, change));
  postgres::QueueEvidence(transaction, site, change.evidence);
  postgres::QueueVerdict(transaction, site, verdict);
  if (verdict.entered_map) {
    QueueEntry(transaction, site,
               {verdict.session, std::nullopt, *verdict.entered_map, verdict.T_map_robot, verdict.T_odom_robot});
  }
  if (change.new_map) ENFILADE_RETURN_IF_ERROR(postgres::NotifyOfPresentGraph(transaction, site));
  return WithContext(transaction.Commit(), NameOf(site, verdict.session));
}

absl::Status DoorVerdictStore::Enter(const CallContext& context, const SiteLease& lease,
                                     const EnteredMap& entered) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  postgres::QueueGraphLock(transaction, lease.site);
  ENFILADE_RETURN_IF_ERROR(postgres::LockSiteLease(transaction, lease));
  if (entered.new_map) postgres::QueueNumberedMap(transaction, lease.site, *entered.new_map);
  QueueEntry(transaction, lease.site, entered);
  absl::Status committed;
  if (entered.new_map) committed = postgres::NotifyOfPresentGraph(transaction, lease.site);
  if (committed.ok()) committed = transaction.Commit();
  if (postgres::SqlStateOf(committed) == "23503") return NotFound("{} does not exist", NameOf(lease.site, entered.map));
  return WithContext(committed, NameOf(lease.site, entered.previous));
}

absl::Status DoorVerdictStore::MarkJudged(const CallContext& context, const SiteLease& lease,
                                          const SessionId& session) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_RETURN_IF_ERROR(postgres::LockSiteLease(transaction, lease));
  transaction.Queue(kMarkJudged, Params(lease.site, session));
  return WithContext(transaction.Commit(), NameOf(lease.site, session));
}

absl::StatusOr<std::vector<closure::DoorVerdict>> DoorVerdictStore::List(const CallContext& context, const SiteId& site,
                                                                         const SessionId& session, std::int64_t after,
                                                                         int limit) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  transaction.Queue(postgres::kSessionExists, Params(site, session));
  transaction.Queue(kListVerdicts, Params(site, session, after, std::int64_t{limit}));
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.Flush());
  if (results[0].rows() == 0) return NotFound("{} does not exist", NameOf(site, session));
  ENFILADE_ASSIGN_OR_RETURN(std::vector<closure::DoorVerdict> verdicts,
                            storage::postgres::ReadRows(results[1], postgres::ReadVerdict));
  if (verdicts.empty()) return verdicts;
  ENFILADE_ASSIGN_OR_RETURN(const auto listed,
                            transaction.Execute(kListComparisons, Params(site, session, verdicts.front().sequence,
                                                                         verdicts.back().sequence)));
  ENFILADE_ASSIGN_OR_RETURN(std::vector<postgres::ComparisonRow> comparisons,
                            storage::postgres::ReadRows(listed, postgres::ReadComparison));
  auto verdict = verdicts.begin();
  for (postgres::ComparisonRow& row : comparisons) {
    while (verdict != verdicts.end() && verdict->sequence < row.sequence) ++verdict;
    if (verdict != verdicts.end()) verdict->comparisons.push_back(std::move(row.comparison));
  }
  return verdicts;
}

absl::StatusOr<std::optional<closure::DoorVerdict>> DoorVerdictStore::FindPassage(const CallContext& context,
                                                                                  const SiteId& site,
                                                                                  const SessionId& session) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto found,
                            storage::postgres::ExecuteAlone(pool_, context, kFindPassage, Params(site, session)));
  if (found.rows() == 0) return std::nullopt;
  ENFILADE_ASSIGN_OR_RETURN(closure::DoorVerdict verdict,
                            storage::postgres::ReadOne(found, postgres::ReadVerdict, "the verdict"));
  return std::optional<closure::DoorVerdict>(std::move(verdict));
}

absl::StatusOr<std::vector<closure::DoorVerdict>> DoorVerdictStore::ListInto(const CallContext& context,
                                                                             const SiteId& site, const MapId& map,
                                                                             int limit) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto listed, storage::postgres::ExecuteAlone(pool_, context, kListInto,
                                                                               Params(site, map, std::int64_t{limit})));
  return storage::postgres::ReadRows(listed, postgres::ReadVerdict);
}

}  // namespace enfilade::storage
