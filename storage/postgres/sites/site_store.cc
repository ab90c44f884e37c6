// SPDX-License-Identifier: Apache-2.0
#include "storage/sites/site_store.h"

#include <array>

#include "core/base/resource_name.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/graph/graph_versions.h"

namespace enfilade::storage {
namespace {

using postgres::ExecuteAlone;
using postgres::Params;
using postgres::Row;
using postgres::Statement;
using postgres::Transaction;

#define ENFILADE_SITE_COLUMNS "site_id, display_name, raw_retention_s, etag, create_time, update_time"

constexpr Statement kInsertSite{"creating the site",
                                "INSERT INTO enfilade.sites (site_id, display_name, raw_retention_s, request_id)"
                                " VALUES ($1, $2, $3, $4) RETURNING " ENFILADE_SITE_COLUMNS};
constexpr Statement kFindSiteRequest{"looking for an earlier request",
                                     "SELECT " ENFILADE_SITE_COLUMNS " FROM enfilade.sites WHERE request_id = $1"};
constexpr Statement kSelectSite{"reading the site",
                                "SELECT " ENFILADE_SITE_COLUMNS " FROM enfilade.sites WHERE site_id = $1"};
constexpr Statement kListSites{"listing sites", "SELECT " ENFILADE_SITE_COLUMNS
                                                " FROM enfilade.sites WHERE site_id > $1 ORDER BY site_id LIMIT $2"};
constexpr Statement kUpdateSite{"updating the site",
                                "UPDATE enfilade.sites SET display_name = $3, raw_retention_s = $4,"
                                " etag = nextval('enfilade.etags'), update_time = now()"
                                " WHERE site_id = $1 AND etag = $2 RETURNING " ENFILADE_SITE_COLUMNS};
constexpr Statement kLockSite{"locking the site", "SELECT etag FROM enfilade.sites WHERE site_id = $1 FOR UPDATE"};
constexpr Statement kCountContent{
    "looking for what belongs to the site",
    "SELECT (SELECT count(*) FROM enfilade.maps WHERE site_id = $1 AND redirect_map_id IS NULL),"
    " (SELECT count(*) FROM enfilade.robots WHERE site_id = $1),"
    " (SELECT count(*) FROM enfilade.sessions WHERE site_id = $1 AND delete_time IS NULL)"};
// Blocks writers of records, which lock nothing but their session's row.
constexpr Statement kLockSessionsOfSite{
    "locking the site's sessions",
    "SELECT session_id FROM enfilade.sessions WHERE site_id = $1 ORDER BY session_id FOR UPDATE"};
// In an order that foreign keys permit.
constexpr std::array kDeletes = {
    Statement{"deleting the blobs of rearrangements", "DELETE FROM enfilade.rearrangement_blobs WHERE site_id = $1"},
    Statement{"deleting rearrangements", "DELETE FROM enfilade.rearrangements WHERE site_id = $1"},
    Statement{"deleting the site's lease", "DELETE FROM enfilade.site_leases WHERE site_id = $1"},
    Statement{"deleting door verdicts", "DELETE FROM enfilade.door_verdicts WHERE site_id = $1"},
    Statement{"deleting robots' poses", "DELETE FROM enfilade.robot_poses WHERE site_id = $1"},
    Statement{"deleting control points", "DELETE FROM enfilade.control_points WHERE site_id = $1"},
    Statement{"deleting link points", "DELETE FROM enfilade.link_points WHERE site_id = $1"},
    Statement{"deleting what is gone from the graph", "DELETE FROM enfilade.graph_removals WHERE site_id = $1"},
    Statement{"deleting the graph's maps", "DELETE FROM enfilade.graph_maps WHERE site_id = $1"},
    Statement{"deleting maps' poses", "DELETE FROM enfilade.map_poses WHERE site_id = $1"},
    Statement{"deleting the graph's versions", "DELETE FROM enfilade.graph_versions WHERE site_id = $1"},
    Statement{"deleting the graph", "DELETE FROM enfilade.site_graphs WHERE site_id = $1"},
    Statement{"deleting tracks", "DELETE FROM enfilade.session_tracks WHERE site_id = $1"},
    Statement{"deleting trajectories", "DELETE FROM enfilade.trajectory_points WHERE site_id = $1"},
    Statement{"deleting closures", "DELETE FROM enfilade.slam_closures WHERE site_id = $1"},
    Statement{"deleting nodes", "DELETE FROM enfilade.slam_nodes WHERE site_id = $1"},
    Statement{"deleting submaps", "DELETE FROM enfilade.slam_submaps WHERE site_id = $1"},
    Statement{"deleting checkpoints", "DELETE FROM enfilade.mapping_checkpoints WHERE site_id = $1"},
    Statement{"deleting leases", "DELETE FROM enfilade.session_leases WHERE site_id = $1"},
    Statement{"deleting layers", "DELETE FROM enfilade.map_layers WHERE site_id = $1"},
    Statement{"deleting tiles", "DELETE FROM enfilade.map_revision_tiles WHERE site_id = $1"},
    Statement{"deleting revisions", "DELETE FROM enfilade.map_revisions WHERE site_id = $1"},
    Statement{"deleting records' blobs", "DELETE FROM enfilade.session_record_blobs WHERE site_id = $1"},
    Statement{"deleting records", "DELETE FROM enfilade.session_records WHERE site_id = $1"},
    Statement{"deleting sessions", "DELETE FROM enfilade.sessions WHERE site_id = $1"},
    Statement{"deleting maps", "DELETE FROM enfilade.maps WHERE site_id = $1"},
    Statement{"deleting robots", "DELETE FROM enfilade.robots WHERE site_id = $1"},
    Statement{"deleting blobs", "DELETE FROM enfilade.blobs WHERE site_id = $1"},
    Statement{"deleting the site", "DELETE FROM enfilade.sites WHERE site_id = $1"},
};

Site ReadSite(Row& row) {
  Site site;
  site.id = SiteId(std::string(row.Text()));
  site.display_name = row.Text();
  if (const auto seconds = row.OptionalInt64()) site.raw_retention = std::chrono::seconds(*seconds);
  site.etag = row.Int64();
  site.create_time = row.Time();
  site.update_time = row.Time();
  return site;
}

std::optional<std::int64_t> RetentionSeconds(const Site& site) {
  if (!site.raw_retention) return std::nullopt;
  return site.raw_retention->count();
}

}  // namespace

absl::StatusOr<Site> SiteStore::Create(const CallContext& context, const Site& site,
                                       const std::string& request_id) const {
  const auto inserted = storage::postgres::ExecuteAlone(
      pool_, context, kInsertSite,
      Params(site.id, site.display_name, RetentionSeconds(site), postgres::NullIfEmpty(request_id)));
  if (inserted.ok()) return storage::postgres::ReadOne(*inserted, ReadSite, NameOf(site.id));
  if (!absl::IsAlreadyExists(inserted.status())) return WithContext(inserted.status(), NameOf(site.id));
  if (!request_id.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(const auto earlier,
                              storage::postgres::ExecuteAlone(pool_, context, kFindSiteRequest, Params(request_id)));
    if (earlier.rows() > 0) return storage::postgres::ReadOne(earlier, ReadSite, NameOf(site.id));
  }
  return AlreadyExists("{} exists already", NameOf(site.id));
}

absl::StatusOr<Site> SiteStore::Get(const CallContext& context, const SiteId& site) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result,
                            storage::postgres::ExecuteAlone(pool_, context, kSelectSite, Params(site)));
  return storage::postgres::ReadOne(result, ReadSite, NameOf(site));
}

absl::StatusOr<std::vector<Site>> SiteStore::List(const CallContext& context, const PageRequest& page) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result,
                            storage::postgres::ExecuteAlone(pool_, context, kListSites,
                                                            Params(page.after, static_cast<std::int64_t>(page.limit))));
  return storage::postgres::ReadRows(result, ReadSite);
}

absl::StatusOr<Site> SiteStore::Update(const CallContext& context, const Site& site) const {
  const auto updated = storage::postgres::ExecuteAlone(
      pool_, context, kUpdateSite, Params(site.id, site.etag, site.display_name, RetentionSeconds(site)));
  if (!updated.ok()) return WithContext(updated.status(), NameOf(site.id));
  if (updated->rows() > 0) return storage::postgres::ReadOne(*updated, ReadSite, NameOf(site.id));
  ENFILADE_RETURN_IF_ERROR(Get(context, site.id).status());
  return postgres::StaleEtag(NameOf(site.id));
}

absl::Status SiteStore::Delete(const CallContext& context, const SiteId& site, std::int64_t etag, bool force) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  postgres::QueueGraphLock(transaction, site);
  transaction.Queue(kLockSite, Params(site));
  transaction.Queue(kCountContent, Params(site));
  ENFILADE_ASSIGN_OR_RETURN(const auto found, transaction.Flush());
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t stored_etag,
                            storage::postgres::ReadOne(
                                found[1], [](Row& row) { return row.Int64(); }, NameOf(site)));
  if (etag != 0 && etag != stored_etag) return postgres::StaleEtag(NameOf(site));
  Row content(found[2], 0);
  const std::int64_t maps = content.Int64();
  const std::int64_t robots = content.Int64();
  const std::int64_t sessions = content.Int64();
  ENFILADE_RETURN_IF_ERROR(content.status());
  if (!force && maps + robots + sessions > 0) {
    return FailedPrecondition("{} still has {} maps, {} robots and {} sessions: delete them first, or use force",
                              NameOf(site), maps, robots, sessions);
  }
  transaction.Queue(kLockSessionsOfSite, Params(site));
  for (const Statement& statement : kDeletes) transaction.Queue(statement, Params(site));
  return WithContext(transaction.Commit(), NameOf(site));
}

}  // namespace enfilade::storage
