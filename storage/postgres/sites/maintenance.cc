// SPDX-License-Identifier: Apache-2.0
#include "storage/sites/maintenance.h"

#include <algorithm>
#include <array>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "storage/postgres/driver/delete_portion.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/sessions/session_purge.h"
#include "storage/postgres/sites/blob_collection.h"
#include "storage/postgres/sites/retention.h"

namespace enfilade::storage {
namespace {

using postgres::ExecuteAlone;
using postgres::Params;
using postgres::ReadRows;
using postgres::Row;
using postgres::Statement;
using postgres::Transaction;

// Sites are listed first and worked on one by one, so that an error in one of them leaves the others alone.
constexpr Statement kListDeleted{"looking for deleted sessions",
                                 "SELECT DISTINCT site_id FROM enfilade.sessions"
                                 " WHERE delete_time IS NOT NULL AND NOT purged ORDER BY site_id"};
constexpr Statement kListForgettable{"looking for sessions that were deleted long ago",
                                     "SELECT DISTINCT site_id FROM enfilade.sessions"
                                     " WHERE purged AND delete_time <= now() - $1 * interval '1 second'"
                                     " ORDER BY site_id"};
constexpr Statement kListExpired{"looking for expired records",
                                 "SELECT DISTINCT site_id FROM enfilade.sessions"
                                 " WHERE records_deleted AND delete_time IS NULL AND NOT purged ORDER BY site_id"};
constexpr Statement kListRetentions{"looking for retentions",
                                    "SELECT site_id FROM enfilade.sites WHERE raw_retention_s IS NOT NULL"
                                    " ORDER BY site_id"};
// Skips sessions that another replica is purging.
constexpr Statement kFindExpired{"looking for a session with expired records",
                                 "SELECT session_id FROM enfilade.sessions WHERE site_id = $1"
                                 " AND records_deleted AND delete_time IS NULL AND NOT purged LIMIT 1"
                                 " FOR UPDATE SKIP LOCKED"};
constexpr Statement kMarkExpired{
    "looking for sessions past their retention",
    "UPDATE enfilade.sessions s SET records_deleted = true FROM enfilade.sites t"
    " WHERE t.site_id = $1 AND s.site_id = $1 AND s.finish_time <= now() - t.raw_retention_s * interval '1 second'"
    " AND s.delete_time IS NULL AND NOT s.records_deleted AND s.state IN (3, 4)"};
#define ENFILADE_LIST_KEEPING(column)                                                                              \
  Statement {                                                                                                      \
    "looking for retentions",                                                                                      \
        "SELECT site_id FROM enfilade.sites WHERE " column " IS NOT NULL AND delete_time IS NULL ORDER BY site_id" \
  }
constexpr Statement kListKeepingSessions = ENFILADE_LIST_KEEPING("session_retention_s");
constexpr Statement kListKeepingRevisions = ENFILADE_LIST_KEEPING("revisions_kept");
constexpr Statement kListKeepingHistory = ENFILADE_LIST_KEEPING("history_retention_s");
constexpr Statement kListKeepingAudit = ENFILADE_LIST_KEEPING("audit_retention_s");
#undef ENFILADE_LIST_KEEPING
constexpr Statement kListLooseBlobs{
    "looking for unused blobs",
    "SELECT s.site_id FROM enfilade.sites s WHERE EXISTS (SELECT FROM enfilade.loose_blobs l"
    "   WHERE l.site_id = s.site_id AND l.since <= now() - $1 * interval '1 second')"
    " OR EXISTS (SELECT FROM enfilade.blob_listings b WHERE b.site_id = s.site_id) ORDER BY s.site_id"};

// What is purged, and where it is found.
struct PurgeKind {
  const Statement& list_sites;
  const Statement& find;  // in a site
  bool with_mapping;
};
const PurgeKind kDeleted{kListDeleted, postgres::kFindSessionToPurge, true};
const PurgeKind kExpired{kListExpired, kFindExpired, false};

absl::StatusOr<std::vector<SiteId>> ListSites(postgres::Pool& pool, const CallContext& context, const Statement& list,
                                              const Params& params = Params()) {
  ENFILADE_ASSIGN_OR_RETURN(const auto result, ExecuteAlone(pool, context, list, params));
  return ReadRows(result, [](Row& row) { return SiteId(std::string(row.Text())); });
}

// What a plan's doors have joined is undone when the plan is no longer in use, however long that takes.
#define ENFILADE_MAY_EXPIRE " AND (prior_map_id IS NULL OR version_undone > 0)"
constexpr Statement kListExpiredUndo{"looking for rearrangements past their retention",
                                     "SELECT DISTINCT site_id FROM enfilade.rearrangements"
                                     " WHERE NOT undo_purged" ENFILADE_MAY_EXPIRE
                                     " AND create_time <= now() - $1 * interval '1 second'"};
// Skips rearrangements that are being undone, or that another replica is purging. They are locked as Undo locks them.
constexpr Statement kFindExpiredUndo{"looking for rearrangements past their retention",
                                     "SELECT rearrangement_id FROM enfilade.rearrangements WHERE site_id = $1"
                                     " AND NOT undo_purged" ENFILADE_MAY_EXPIRE
                                     " AND create_time <= now() - $2 * interval '1 second'"
                                     " ORDER BY create_time LIMIT 1 FOR UPDATE SKIP LOCKED"};
constexpr Statement kMarkUndoPurged{"closing the rearrangement",
                                    "UPDATE enfilade.rearrangements SET undo_expired = true, undo_purged = $3"
                                    " WHERE site_id = $1 AND rearrangement_id = $2"};
constexpr std::array kUndoTables = {ENFILADE_DELETE_PORTION("rearrangement_images", "rearrangement_id = $2", "$3"),
                                    ENFILADE_DELETE_PORTION("rearrangement_blobs", "rearrangement_id = $2", "$3")};

// Deletes up to `limit` rows of one session; unset if there is none to purge.
absl::StatusOr<std::optional<std::int64_t>> PurgeOne(postgres::Pool& pool, const CallContext& context,
                                                     const PurgeKind& kind, const SiteId& site, std::int64_t limit) {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool, context));
  ENFILADE_ASSIGN_OR_RETURN(const auto found, transaction.Execute(kind.find, Params(site)));
  if (found.rows() == 0) return std::nullopt;
  Row row(found, 0);
  const std::string session(row.Text());
  ENFILADE_RETURN_IF_ERROR(row.status());
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t deleted,
                            postgres::PurgeSession(transaction, site, session, kind.with_mapping, limit));
  ENFILADE_RETURN_IF_ERROR(transaction.Commit());
  return deleted;
}

// Deletes up to `limit` rows of what undoing one rearrangement needs; unset if there is none to purge.
absl::StatusOr<std::optional<std::int64_t>> PurgeOneUndo(postgres::Pool& pool, const CallContext& context,
                                                         const SiteId& site, std::int64_t kept_s, std::int64_t limit) {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool, context));
  ENFILADE_ASSIGN_OR_RETURN(const auto found, transaction.Execute(kFindExpiredUndo, Params(site, kept_s)));
  if (found.rows() == 0) return std::nullopt;
  Row row(found, 0);
  const std::string rearrangement(row.Text());
  ENFILADE_RETURN_IF_ERROR(row.status());
  std::int64_t deleted = 0;
  for (const Statement& deletion : kUndoTables) {
    if (deleted >= limit) break;
    ENFILADE_ASSIGN_OR_RETURN(const auto result,
                              transaction.Execute(deletion, Params(site, rearrangement, limit - deleted)));
    deleted += result.affected();
  }
  transaction.Queue(kMarkUndoPurged, Params(site, rearrangement, deleted < limit));
  ENFILADE_RETURN_IF_ERROR(transaction.Commit());
  return deleted;
}

// Calls `purge_next` with the rows left of `limit` until there is nothing to purge. Adds the rows deleted to `total`,
// also if an error ends it.
using PurgeNext = std::function<absl::StatusOr<std::optional<std::int64_t>>(std::int64_t)>;
absl::Status PurgeAll(std::int64_t limit, const PurgeNext& purge_next, std::int64_t& total) {
  while (total < limit) {
    ENFILADE_ASSIGN_OR_RETURN(const auto deleted, purge_next(limit - total));
    if (!deleted) break;
    total += *deleted;
  }
  return absl::OkStatus();
}

// Deletes up to `limit` rows in all, site by site. The first error of a site, naming it, is returned once there is
// nothing left to do in the others.
using PurgeInSite = std::function<absl::StatusOr<std::optional<std::int64_t>>(const SiteId&, std::int64_t)>;
absl::StatusOr<std::int64_t> PurgeSites(const std::vector<SiteId>& sites, std::int64_t limit, const PurgeInSite& purge,
                                        absl::Status error = {}) {
  std::int64_t total = 0;
  for (const SiteId& site : sites) {
    const auto purge_next = [&](std::int64_t rest) { return purge(site, rest); };
    error.Update(WithContext(PurgeAll(limit, purge_next, total), NameOf(site)));
    if (total >= limit) return total;
  }
  if (!error.ok()) return error;
  return total;
}

using PurgeListedSite = absl::StatusOr<std::optional<std::int64_t>> (*)(postgres::Pool& pool,
                                                                        const CallContext& context, const SiteId& site,
                                                                        std::int64_t limit);
absl::StatusOr<std::int64_t> PurgeListed(postgres::Pool& pool, const CallContext& context, const Statement& list,
                                         PurgeListedSite purge, std::int64_t limit) {
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<SiteId> sites, ListSites(pool, context, list));
  return PurgeSites(sites, limit,
                    [&](const SiteId& site, std::int64_t rest) { return purge(pool, context, site, rest); });
}

// Until `limit` things have been looked at or deleted, in all. Errors as PurgeSites.
using LookInSite = std::function<absl::StatusOr<MaintenancePortion>(const SiteId&, std::int64_t)>;
absl::StatusOr<MaintenancePortion> LookInSites(const std::vector<SiteId>& sites, std::int64_t limit,
                                               const LookInSite& look) {
  MaintenancePortion total;
  absl::Status error;
  const auto done = [&] { return std::max(total.looked_at, total.deleted); };
  for (const SiteId& site : sites) {
    if (done() >= limit) return total;
    const auto portion = look(site, limit - done());
    if (portion.ok()) {
      total.looked_at += portion->looked_at;
      total.deleted += portion->deleted;
    }
    error.Update(WithContext(portion.status(), NameOf(site)));
  }
  if (!error.ok() && done() < limit) return error;
  return total;
}

absl::StatusOr<std::int64_t> PurgeSessions(postgres::Pool& pool, const CallContext& context, const PurgeKind& kind,
                                           std::int64_t limit, absl::Status error = {}) {
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<SiteId> sites, ListSites(pool, context, kind.list_sites));
  return PurgeSites(
      sites, limit, [&](const SiteId& site, std::int64_t rest) { return PurgeOne(pool, context, kind, site, rest); },
      std::move(error));
}

}  // namespace

absl::StatusOr<std::int64_t> Maintenance::PurgeDeletedSessions(const CallContext& context, std::int64_t limit) const {
  return PurgeSessions(pool_, context, kDeleted, limit);
}

absl::StatusOr<std::int64_t> Maintenance::ForgetDeletedSessions(const CallContext& context, std::chrono::seconds kept,
                                                                std::int64_t limit) const {
  ENFILADE_ASSIGN_OR_RETURN(
      const std::vector<SiteId> sites,
      ListSites(pool_, context, kListForgettable, Params(static_cast<std::int64_t>(kept.count()))));
  return PurgeSites(sites, limit, [&](const SiteId& site, std::int64_t rest) {
    return postgres::ForgetSessions(pool_, context, site, kept, rest);
  });
}

absl::StatusOr<std::int64_t> Maintenance::DeleteExpiredRecords(const CallContext& context, std::int64_t limit) const {
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<SiteId> sites, ListSites(pool_, context, kListRetentions));
  absl::Status error;
  for (const SiteId& site : sites) {
    error.Update(WithContext(ExecuteAlone(pool_, context, kMarkExpired, Params(site)).status(), NameOf(site)));
  }
  return PurgeSessions(pool_, context, kExpired, limit, error);
}

absl::StatusOr<std::int64_t> Maintenance::DeleteExpiredUndo(const CallContext& context, std::chrono::seconds kept,
                                                            std::int64_t limit) const {
  const auto kept_s = static_cast<std::int64_t>(kept.count());
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<SiteId> sites,
                            ListSites(pool_, context, kListExpiredUndo, Params(kept_s)));
  return PurgeSites(sites, limit, [&](const SiteId& site, std::int64_t rest) {
    return PurgeOneUndo(pool_, context, site, kept_s, rest);
  });
}

absl::StatusOr<std::int64_t> Maintenance::DeleteFinishedSessions(const CallContext& context, std::int64_t limit) const {
  return PurgeListed(pool_, context, kListKeepingSessions, postgres::DeleteFinishedSessions, limit);
}

absl::StatusOr<std::int64_t> Maintenance::DeleteGraphHistory(const CallContext& context, std::int64_t limit) const {
  return PurgeListed(pool_, context, kListKeepingHistory, postgres::DeleteGraphHistory, limit);
}

absl::StatusOr<std::int64_t> Maintenance::DeleteAuditEntries(const CallContext& context, std::int64_t limit) const {
  return PurgeListed(pool_, context, kListKeepingAudit, postgres::DeleteAuditEntries, limit);
}

absl::StatusOr<MaintenancePortion> Maintenance::DeleteRevisions(const CallContext& context, std::int64_t limit) const {
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<SiteId> sites, ListSites(pool_, context, kListKeepingRevisions));
  return LookInSites(sites, limit, [&](const SiteId& site, std::int64_t rest) {
    return postgres::DeleteRevisions(pool_, context, site, rest);
  });
}

absl::StatusOr<MaintenancePortion> Maintenance::CollectBlobs(const CallContext& context, std::chrono::seconds grace,
                                                             std::int64_t limit) const {
  ENFILADE_ASSIGN_OR_RETURN(
      const std::vector<SiteId> sites,
      ListSites(pool_, context, kListLooseBlobs, Params(static_cast<std::int64_t>(grace.count()))));
  return LookInSites(sites, limit, [&](const SiteId& site, std::int64_t rest) {
    return postgres::CollectBlobsOf(pool_, context, site, grace, rest);
  });
}

}  // namespace enfilade::storage
