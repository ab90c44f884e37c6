// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/sites/retention.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/status_macros.h"
#include "storage/graph/graph_store.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/driver/transaction.h"
#include "storage/postgres/sessions/session_deletion.h"

namespace enfilade::storage::postgres {
namespace {

// Skips maps that another replica works on, or that get a revision.
constexpr Statement kFindReview{"looking for revisions past their retention",
                                "SELECT map_id FROM enfilade.revision_reviews WHERE site_id = $1 AND due_time <= now()"
                                " ORDER BY due_time LIMIT 1 FOR UPDATE SKIP LOCKED"};
// Revisions of the map $2 that are not among the newest ones, have no tag, are no layers, to which no alias leads or
// can be led back, and that undoing a rearrangement of the map cannot need: those of before it.
#define ENFILADE_SUPERSEDED                                                                                        \
  " FROM enfilade.map_revisions r"                                                                                 \
  " JOIN enfilade.sites s ON s.site_id = r.site_id"                                                                \
  " JOIN enfilade.maps m ON m.site_id = r.site_id AND m.map_id = r.map_id"                                         \
  " WHERE r.site_id = $1 AND r.map_id = $2 AND r.revision <= m.current_revision - s.revisions_kept AND r.tag = ''" \
  " AND NOT EXISTS (SELECT FROM enfilade.map_layers l WHERE l.site_id = $1 AND l.map_id = $2"                      \
  "   AND l.revision = r.revision)"                                                                                \
  " AND NOT EXISTS (SELECT FROM enfilade.map_aliases n WHERE n.site_id = $1 AND n.map_id = $2"                     \
  "   AND (n.revision = r.revision OR n.previous_revision = r.revision))"                                          \
  " AND r.create_time > coalesce((SELECT max(a.create_time) FROM enfilade.rearrangement_images i"                  \
  "   JOIN enfilade.rearrangements a ON a.site_id = i.site_id AND a.rearrangement_id = i.rearrangement_id"         \
  "   WHERE i.site_id = $1 AND a.site_id = $1 AND i.key = $2 AND i.relation IN ('map', 'layers')), '-infinity')"
#define ENFILADE_REVISION_EXPIRES "r.create_time + coalesce(s.revision_retention_s, 0) * interval '1 second'"
// With their tiles about $3 rows: one too many at most, so that there is progress.
constexpr Statement kDeleteRevisions{
    "deleting revisions past their retention",
    "DELETE FROM enfilade.map_revisions d USING ("
    "  SELECT revision, sum(tile_count + 1) OVER (ORDER BY revision) - tile_count - 1 AS rows_before FROM ("
    "    SELECT r.revision, r.tile_count" ENFILADE_SUPERSEDED " AND " ENFILADE_REVISION_EXPIRES
    " <= now()"
    "    ORDER BY r.revision LIMIT $3) oldest) u"
    " WHERE d.site_id = $1 AND d.map_id = $2 AND d.revision = u.revision AND u.rows_before < $3"
    " RETURNING d.tile_count + 1"};
constexpr Statement kSetNextReview{"setting the map's next review",
                                   "UPDATE enfilade.revision_reviews SET due_time = coalesce("
                                   "  (SELECT " ENFILADE_REVISION_EXPIRES ENFILADE_SUPERSEDED
                                   " ORDER BY r.revision LIMIT 1), 'infinity')"
                                   " WHERE site_id = $1 AND map_id = $2"};

// Of the oldest versions, those past their retention. Poses are read at the last optimisations ($2 of them).
constexpr Statement kDeleteVersions{
    "deleting old versions of the graph",
    "WITH oldest AS (SELECT v.version, v.create_time, v.cause FROM enfilade.graph_versions v WHERE v.site_id = $1"
    "   ORDER BY v.version LIMIT $3 + $2 + 1),"
    " kept AS (SELECT version FROM enfilade.graph_versions WHERE site_id = $1 AND cause = 7"
    "   ORDER BY version DESC LIMIT $2)"
    " DELETE FROM enfilade.graph_versions d USING oldest o, enfilade.sites s, enfilade.site_graphs g"
    " WHERE d.site_id = $1 AND d.version = o.version AND s.site_id = $1 AND g.site_id = $1"
    "   AND o.create_time <= now() - s.history_retention_s * interval '1 second' AND o.version < g.graph_version"
    "   AND NOT EXISTS (SELECT FROM kept k WHERE k.version = o.version)"
    " RETURNING d.version"};
constexpr Statement kForgetRemovals{"deleting what was removed from the graph long ago",
                                    "DELETE FROM enfilade.graph_removals WHERE site_id = $1 AND removed_version <= $2"};
constexpr Statement kSetForgotten{"storing what is forgotten of the graph",
                                  "UPDATE enfilade.site_graphs SET forgotten_version = greatest(forgotten_version, $2)"
                                  " WHERE site_id = $1"};
constexpr Statement kDeleteEntries{
    "deleting old audit entries",
    "WITH oldest AS (SELECT audit_id, time FROM enfilade.audit_log WHERE site_id = $1 ORDER BY audit_id LIMIT $2)"
    " DELETE FROM enfilade.audit_log d USING oldest o, enfilade.sites s"
    " WHERE d.site_id = $1 AND d.audit_id = o.audit_id AND s.site_id = $1"
    "   AND o.time <= now() - s.audit_retention_s * interval '1 second'"};
// Those that nothing refers to: no later session, no revision or layer of a map, and nothing that undoing a
// rearrangement from before brings back.
constexpr Statement kForgetSessions{
    "forgetting deleted sessions",
    "WITH due AS (SELECT s.session_id FROM enfilade.sessions s WHERE s.site_id = $1 AND s.purged"
    "   AND s.delete_time <= now() - $2 * interval '1 second'"
    "   AND NOT EXISTS (SELECT FROM enfilade.sessions o WHERE o.site_id = $1 AND o.previous_session_id = s.session_id)"
    "   AND NOT EXISTS (SELECT FROM enfilade.sessions o WHERE o.site_id = $1 AND o.cut_from_session_id = s.session_id)"
    "   AND NOT EXISTS (SELECT FROM enfilade.map_revisions r WHERE r.site_id = $1 AND r.session_id = s.session_id)"
    "   AND NOT EXISTS (SELECT FROM enfilade.map_layers l WHERE l.site_id = $1 AND l.session_id = s.session_id)"
    "   AND NOT EXISTS (SELECT FROM enfilade.rearrangements a WHERE a.site_id = $1 AND NOT a.undo_purged"
    "     AND a.prior_map_id IS NULL AND a.create_time <= s.delete_time)"
    "   ORDER BY s.delete_time LIMIT $3 FOR UPDATE SKIP LOCKED)"
    " DELETE FROM enfilade.sessions d USING due WHERE d.site_id = $1 AND d.session_id = due.session_id"};
// Skips sessions that somebody is working on.
constexpr Statement kFindFinished{
    "looking for sessions past their retention",
    "SELECT d.session_id FROM enfilade.sessions d WHERE d.site_id = $1 AND d.delete_time IS NULL"
    " AND d.state IN (3, 4) AND d.finish_time <= now() - (SELECT session_retention_s FROM enfilade.sites"
    "   WHERE site_id = $1) * interval '1 second' ORDER BY d.finish_time LIMIT $2"};

std::optional<std::int64_t> UnsetIfNone(std::int64_t deleted) {
  return deleted > 0 ? std::optional(deleted) : std::nullopt;
}

// Unset if no map is due.
absl::StatusOr<std::optional<std::int64_t>> DeleteRevisionsOfOneMap(Pool& pool, const CallContext& context,
                                                                    const SiteId& site, std::int64_t limit) {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool, context));
  ENFILADE_ASSIGN_OR_RETURN(const Result found, transaction.Execute(kFindReview, Params(site)));
  if (found.rows() == 0) return std::nullopt;
  Row row(found, 0);
  const MapId map{std::string(row.Text())};
  ENFILADE_RETURN_IF_ERROR(row.status());
  transaction.Queue(kDeleteRevisions, Params(site, map, limit));
  transaction.Queue(kSetNextReview, Params(site, map));
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.FlushAndCommit());
  ENFILADE_ASSIGN_OR_RETURN(const auto counts, ReadRows(results[0], [](Row& deleted) { return deleted.Int64(); }));
  std::int64_t total = 0;
  for (const std::int64_t count : counts) total += count;
  return total;
}

}  // namespace

absl::StatusOr<MaintenancePortion> DeleteRevisions(Pool& pool, const CallContext& context, const SiteId& site,
                                                   std::int64_t limit) {
  MaintenancePortion total;
  while (std::max(total.looked_at, total.deleted) < limit) {
    ENFILADE_ASSIGN_OR_RETURN(const auto deleted, DeleteRevisionsOfOneMap(pool, context, site, limit - total.deleted));
    if (!deleted) break;
    ++total.looked_at;
    total.deleted += *deleted;
  }
  return total;
}

absl::StatusOr<std::optional<std::int64_t>> DeleteGraphHistory(Pool& pool, const CallContext& context,
                                                               const SiteId& site, std::int64_t limit) {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool, context));
  ENFILADE_ASSIGN_OR_RETURN(
      const Result deleted,
      transaction.Execute(kDeleteVersions, Params(site, std::int64_t{GraphReader::kKeptOptimizations}, limit)));
  ENFILADE_ASSIGN_OR_RETURN(const auto versions, ReadRows(deleted, [](Row& row) { return row.Int64(); }));
  if (versions.empty()) return std::nullopt;
  const std::int64_t forgotten = *std::max_element(versions.begin(), versions.end());
  transaction.Queue(kForgetRemovals, Params(site, forgotten));
  transaction.Queue(kSetForgotten, Params(site, forgotten));
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.FlushAndCommit());
  return static_cast<std::int64_t>(versions.size()) + results[0].affected();
}

absl::StatusOr<std::optional<std::int64_t>> DeleteAuditEntries(Pool& pool, const CallContext& context,
                                                               const SiteId& site, std::int64_t limit) {
  ENFILADE_ASSIGN_OR_RETURN(const Result deleted, ExecuteAlone(pool, context, kDeleteEntries, Params(site, limit)));
  return UnsetIfNone(deleted.affected());
}

absl::StatusOr<std::optional<std::int64_t>> ForgetSessions(Pool& pool, const CallContext& context, const SiteId& site,
                                                           std::chrono::seconds kept, std::int64_t limit) {
  const auto kept_s = static_cast<std::int64_t>(kept.count());
  ENFILADE_ASSIGN_OR_RETURN(const Result deleted,
                            ExecuteAlone(pool, context, kForgetSessions, Params(site, kept_s, limit)));
  return UnsetIfNone(deleted.affected());
}

absl::StatusOr<std::optional<std::int64_t>> DeleteFinishedSessions(Pool& pool, const CallContext& context,
                                                                   const SiteId& site, std::int64_t limit) {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool, context));
  ENFILADE_ASSIGN_OR_RETURN(const Result found, transaction.Execute(kFindFinished, Params(site, limit)));
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<std::string> ids,
                            ReadRows(found, [](Row& row) { return std::string(row.Text()); }));
  if (ids.empty()) return std::nullopt;
  const std::vector<std::string_view> sessions(ids.begin(), ids.end());
  transaction.Queue(kRevokeLeases, Params(site, sessions));
  transaction.Queue(kMarkSessionsDeleted, Params(site, sessions));
  ENFILADE_RETURN_IF_ERROR(transaction.Commit());
  return static_cast<std::int64_t>(ids.size());
}

}  // namespace enfilade::storage::postgres
