// SPDX-License-Identifier: Apache-2.0
#include "storage/sites/site_deletion.h"

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/resource_name.h"
#include "storage/postgres/driver/delete_portion.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/sessions/session_deletion.h"
#include "storage/postgres/sessions/session_purge.h"

namespace enfilade::storage {
namespace {

using postgres::ExecuteAlone;
using postgres::Params;
using postgres::Row;
using postgres::Statement;
using postgres::Transaction;

constexpr Statement kListDeletedSites{"looking for deleted sites",
                                      "SELECT site_id, delete_actor FROM enfilade.sites"
                                      " WHERE delete_time IS NOT NULL ORDER BY site_id"};
constexpr Statement kTakeDeletedSite{"looking for the deleted site",
                                     "SELECT deletion_step FROM enfilade.sites WHERE site_id = $1"
                                     " AND delete_time IS NOT NULL FOR NO KEY UPDATE SKIP LOCKED"};
constexpr Statement kStoreProgress{"storing the deletion's progress",
                                   "UPDATE enfilade.sites SET deletion_step = $2, deleted_rows = deleted_rows + $3"
                                   " WHERE site_id = $1 AND delete_time IS NOT NULL"};
// Nobody can take it again.
constexpr Statement kRevokeSiteLease{
    "revoking the site's lease",
    "INSERT INTO enfilade.site_leases AS l (site_id, owner, token, expires_at) VALUES ($1, '', 1, 'infinity')"
    " ON CONFLICT (site_id) DO UPDATE SET owner = '', token = l.token + 1, expires_at = 'infinity'"};
constexpr Statement kFindSessions{
    "looking for the site's sessions",
    "SELECT session_id FROM enfilade.sessions WHERE site_id = $1 AND (delete_time IS NULL"
    " OR previous_session_id IS NOT NULL OR cut_from_session_id IS NOT NULL) ORDER BY session_id LIMIT $2"};
// So that sessions can be deleted in any order.
constexpr Statement kUnlinkSessions{"unlinking sessions",
                                    "UPDATE enfilade.sessions SET previous_session_id = NULL,"
                                    " cut_from_session_id = NULL WHERE site_id = $1 AND session_id = ANY ($2)"};
constexpr Statement kDropSiteLease{"deleting the site's lease", "DELETE FROM enfilade.site_leases WHERE site_id = $1"};
constexpr Statement kDropRequest{"deleting the site's request",
                                 "DELETE FROM enfilade.site_requests WHERE site_id = $1"};
constexpr Statement kDropSite{"deleting the site", "DELETE FROM enfilade.sites WHERE site_id = $1"};

// The steps by their numbers, which are in the database: first sessions stop growing, then their rows go, then those of
// the tables below, in an order that foreign keys permit, and at last the site's own.
constexpr std::int32_t kStop = 0;
constexpr std::int32_t kPurgeSessions = 1;
constexpr std::int32_t kFirstTable = 2;
#define ENFILADE_OF_SITE(table) ENFILADE_DELETE_PORTION(table, "true", "$2")
constexpr std::array kTables = {
    ENFILADE_OF_SITE("map_overlay_tiles"),
    ENFILADE_OF_SITE("map_overlays"),
    ENFILADE_OF_SITE("map_edits"),
    ENFILADE_OF_SITE("map_drafts"),
    ENFILADE_OF_SITE("map_areas"),
    ENFILADE_OF_SITE("prior_map_files"),
    ENFILADE_OF_SITE("prior_maps"),
    ENFILADE_OF_SITE("rearrangement_images"),
    ENFILADE_OF_SITE("rearrangement_blobs"),
    ENFILADE_OF_SITE("rearrangement_parts"),
    ENFILADE_OF_SITE("rearrangements"),
    ENFILADE_OF_SITE("robot_poses"),
    ENFILADE_OF_SITE("control_points"),
    ENFILADE_OF_SITE("link_point_evidence"),
    ENFILADE_OF_SITE("link_point_anchors"),
    ENFILADE_OF_SITE("link_points"),
    ENFILADE_OF_SITE("graph_removals"),
    ENFILADE_OF_SITE("graph_maps"),
    ENFILADE_OF_SITE("map_poses"),
    ENFILADE_OF_SITE("graph_versions"),
    ENFILADE_OF_SITE("site_graphs"),
    ENFILADE_OF_SITE("map_layer_run_tiles"),
    ENFILADE_OF_SITE("map_layer_runs"),
    ENFILADE_OF_SITE("map_layer_stacks"),
    ENFILADE_OF_SITE("map_layer_tiles"),
    ENFILADE_OF_SITE("map_layers"),
    ENFILADE_OF_SITE("raster_pyramid_tiles"),
    ENFILADE_OF_SITE("raster_pyramids"),
    ENFILADE_OF_SITE("map_aliases"),
    ENFILADE_OF_SITE("map_revision_tiles"),
    ENFILADE_OF_SITE("map_revisions"),
    ENFILADE_OF_SITE("revision_reviews"),
    ENFILADE_OF_SITE("sessions"),
    ENFILADE_OF_SITE("maps"),
    ENFILADE_OF_SITE("robots"),
    ENFILADE_OF_SITE("blobs"),
    ENFILADE_OF_SITE("loose_blobs"),
    ENFILADE_OF_SITE("blob_listings"),
};
#undef ENFILADE_OF_SITE
constexpr auto kLast = static_cast<std::int32_t>(kFirstTable + kTables.size());

// What a step did: it has ended when it found less to do than it might.
struct StepResult {
  bool ended = false;
  std::int64_t deleted = 0;
};

// Late records and what mapping would still store are refused from then on.
absl::StatusOr<StepResult> StopSessions(Transaction& transaction, const SiteId& site, std::int64_t limit) {
  transaction.Queue(kRevokeSiteLease, Params(site));
  ENFILADE_ASSIGN_OR_RETURN(const auto found, transaction.Execute(kFindSessions, Params(site, limit)));
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<std::string> ids,
                            postgres::ReadRows(found, [](Row& row) { return std::string(row.Text()); }));
  const std::vector<std::string_view> sessions(ids.begin(), ids.end());
  transaction.Queue(postgres::kRevokeLeases, Params(site, sessions));
  transaction.Queue(postgres::kMarkSessionsDeleted, Params(site, sessions));
  transaction.Queue(kUnlinkSessions, Params(site, sessions));
  return StepResult{.ended = found.rows() < limit};
}

absl::StatusOr<StepResult> PurgeNextSession(Transaction& transaction, const SiteId& site, std::int64_t limit) {
  ENFILADE_ASSIGN_OR_RETURN(const auto found, transaction.Execute(postgres::kFindSessionToPurge, Params(site)));
  if (found.rows() == 0) return StepResult{.ended = true};
  ENFILADE_ASSIGN_OR_RETURN(const std::string session,
                            postgres::ReadOne(
                                found, [](Row& row) { return std::string(row.Text()); }, "the session"));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t deleted,
                            postgres::PurgeSession(transaction, site, session, true, limit));
  return StepResult{.deleted = deleted};
}

absl::StatusOr<StepResult> RunStep(Transaction& transaction, const SiteId& site, std::int32_t step,
                                   std::int64_t limit) {
  if (step == kStop) return StopSessions(transaction, site, limit);
  if (step == kPurgeSessions) return PurgeNextSession(transaction, site, limit);
  const Statement& deletion = kTables.at(static_cast<std::size_t>(step - kFirstTable));
  ENFILADE_ASSIGN_OR_RETURN(const auto result, transaction.Execute(deletion, Params(site, limit)));
  return StepResult{.ended = result.affected() < limit, .deleted = result.affected()};
}

// Everything else is gone.
absl::StatusOr<SiteDeletion::Portion> DropSite(Transaction& transaction, const SiteId& site) {
  transaction.Queue(kDropSiteLease, Params(site));
  transaction.Queue(kDropRequest, Params(site));
  transaction.Queue(kDropSite, Params(site));
  ENFILADE_RETURN_IF_ERROR(transaction.Commit());
  return SiteDeletion::Portion{SiteDeletion::Progress::kDone, 1};
}

absl::StatusOr<SiteDeletion::Portion> RunPortion(postgres::Pool& pool, const CallContext& context, const SiteId& site,
                                                 std::int64_t limit) {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool, context));
  ENFILADE_ASSIGN_OR_RETURN(const auto taken, transaction.Execute(kTakeDeletedSite, Params(site)));
  if (taken.rows() == 0) return SiteDeletion::Portion{SiteDeletion::Progress::kTaken};
  ENFILADE_ASSIGN_OR_RETURN(const std::int32_t step, postgres::ReadOne(
                                                         taken, [](Row& row) { return row.Int32(); }, NameOf(site)));
  if (step >= kLast) return DropSite(transaction, site);
  ENFILADE_ASSIGN_OR_RETURN(const StepResult result, RunStep(transaction, site, step, limit));
  transaction.Queue(kStoreProgress, Params(site, result.ended ? step + 1 : step, result.deleted));
  ENFILADE_RETURN_IF_ERROR(transaction.Commit());
  return SiteDeletion::Portion{SiteDeletion::Progress::kMore, result.deleted};
}

}  // namespace

absl::StatusOr<std::vector<DeletedSite>> SiteDeletion::List(const CallContext& context) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result, ExecuteAlone(pool_, context, kListDeletedSites, Params()));
  return postgres::ReadRows(result, [](Row& row) {
    DeletedSite site;
    site.id = SiteId(std::string(row.Text()));
    site.actor = row.Text();
    return site;
  });
}

absl::StatusOr<SiteDeletion::Portion> SiteDeletion::DeletePortion(const CallContext& context, const SiteId& site,
                                                                  std::int64_t limit) const {
  const auto portion = RunPortion(pool_, context, site, limit);
  // A row that refers to this portion's was written after its table's step: the steps begin again.
  if (postgres::SqlStateOf(portion.status()) == "23503") {
    ENFILADE_RETURN_IF_ERROR(
        ExecuteAlone(pool_, context, kStoreProgress, Params(site, kStop, std::int64_t{0})).status());
  }
  if (!portion.ok()) return WithContext(portion.status(), NameOf(site));
  return portion;
}

}  // namespace enfilade::storage
