// SPDX-License-Identifier: Apache-2.0
#include "storage/maps/map_alias_store.h"

#include <tuple>

#include "core/base/resource_name.h"
#include "storage/postgres/driver/etag.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/driver/transaction.h"
#include "storage/postgres/maps/revision_rows.h"

namespace enfilade::storage {
namespace {

using postgres::ExecuteAlone;
using postgres::Params;
using postgres::Row;
using postgres::Statement;
using postgres::Transaction;

#define ENFILADE_ALIAS_COLUMNS \
  "site_id, map_id, alias_id, revision, coalesce(previous_revision, 0), actor, etag, update_time"

// Those who change the map's aliases follow one another, so that their number can be limited.
constexpr Statement kLockMapOfAlias{"locking the map",
                                    "SELECT FROM enfilade.maps WHERE site_id = $1 AND map_id = $2 FOR NO KEY UPDATE"};
constexpr Statement kFindMapOfAlias{"looking for the map",
                                    "SELECT FROM enfilade.maps WHERE site_id = $1 AND map_id = $2"};
constexpr Statement kSelectAlias{"reading the alias",
                                 "SELECT " ENFILADE_ALIAS_COLUMNS
                                 " FROM enfilade.map_aliases WHERE site_id = $1 AND map_id = $2 AND alias_id = $3"};
constexpr Statement kListAliases{"listing aliases",
                                 "SELECT " ENFILADE_ALIAS_COLUMNS
                                 " FROM enfilade.map_aliases WHERE site_id = $1 AND map_id = $2 ORDER BY alias_id"};
constexpr Statement kInsertAlias{
    "storing the alias",
    "INSERT INTO enfilade.map_aliases (site_id, map_id, alias_id, revision, actor, etag)"
    " SELECT $1, $2, $3, $4, $5, $6 WHERE $7 > (SELECT count(*) FROM enfilade.map_aliases WHERE site_id = $1"
    "   AND map_id = $2) RETURNING " ENFILADE_ALIAS_COLUMNS};
#define ENFILADE_CHANGE_ALIAS(assignments)                                     \
  "UPDATE enfilade.map_aliases SET " assignments                               \
  ", previous_revision = revision, actor = $4, etag = $5, update_time = now()" \
  " WHERE site_id = $1 AND map_id = $2 AND alias_id = $3"
constexpr Statement kMoveAlias{"moving the alias",
                               ENFILADE_CHANGE_ALIAS("revision = $6") " RETURNING " ENFILADE_ALIAS_COLUMNS};
constexpr Statement kRollBackAlias{
    "leading the alias back",
    ENFILADE_CHANGE_ALIAS("revision = previous_revision") " RETURNING " ENFILADE_ALIAS_COLUMNS};
constexpr Statement kDeleteAlias{"deleting the alias",
                                 "DELETE FROM enfilade.map_aliases"
                                 " WHERE site_id = $1 AND map_id = $2 AND alias_id = $3"};

MapAlias ReadAlias(Row& row) {
  MapAlias alias;
  alias.site = SiteId(std::string(row.Text()));
  alias.map = MapId(std::string(row.Text()));
  alias.id = MapAliasId(std::string(row.Text()));
  alias.revision = row.Int64();
  alias.previous_revision = row.Int64();
  alias.actor = row.Text();
  alias.etag = row.Int64();
  alias.update_time = row.Time();
  return alias;
}

absl::Status LockMap(Transaction& transaction, const SiteId& site, const MapId& map) {
  ENFILADE_ASSIGN_OR_RETURN(const auto locked, transaction.Execute(kLockMapOfAlias, Params(site, map)));
  return locked.rows() > 0 ? absl::OkStatus() : NotFound("{} does not exist", NameOf(site, map));
}

// The alias as it is while the map is locked. NOT_FOUND; ABORTED on a stale `etag` (0: any).
absl::StatusOr<MapAlias> LockAlias(Transaction& transaction, const SiteId& site, const MapId& map, const MapAliasId& id,
                                   std::int64_t etag) {
  ENFILADE_RETURN_IF_ERROR(LockMap(transaction, site, map));
  ENFILADE_ASSIGN_OR_RETURN(const auto result, transaction.Execute(kSelectAlias, Params(site, map, id)));
  const std::string name = NameOf(site, map, id);
  ENFILADE_ASSIGN_OR_RETURN(MapAlias alias, postgres::ReadOne(result, ReadAlias, name));
  if (etag != 0 && etag != alias.etag) return postgres::StaleEtag(name);
  return alias;
}

// A row that was written, once the transaction is committed. The revision that it no longer leads to may be due.
absl::StatusOr<MapAlias> CommitAlias(Transaction& transaction, const absl::StatusOr<postgres::Result>& written,
                                     const MapAlias& wanted) {
  if (postgres::ConstraintOf(written.status()) == "map_aliases_revision_fkey") {
    return NotFound("{}/revisions/{} does not exist", NameOf(wanted.site, wanted.map), wanted.revision);
  }
  const std::string name = NameOf(wanted.site, wanted.map, wanted.id);
  ENFILADE_RETURN_IF_ERROR(WithContext(written.status(), name));
  postgres::QueueRevisionReview(transaction, {wanted.site, wanted.map});
  ENFILADE_RETURN_IF_ERROR(WithContext(transaction.Commit(), name));
  return postgres::ReadOne(*written, ReadAlias, name);
}

}  // namespace

absl::StatusOr<MapAlias> MapAliasStore::Set(const CallContext& context, const MapAlias& alias) const {
  const auto& [site, map, id] = std::tie(alias.site, alias.map, alias.id);
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  const absl::StatusOr<MapAlias> stored = LockAlias(transaction, site, map, id, alias.etag);
  if (stored.ok() && stored->revision == alias.revision) return stored;
  if (stored.ok()) {
    return CommitAlias(
        transaction,
        transaction.Execute(kMoveAlias, Params(site, map, id, context.actor, postgres::NewEtag(), alias.revision)),
        alias);
  }
  if (!absl::IsNotFound(stored.status()) || alias.etag != 0) return stored.status();
  ENFILADE_RETURN_IF_ERROR(LockMap(transaction, site, map));
  const absl::StatusOr<postgres::Result> inserted = transaction.Execute(
      kInsertAlias,
      Params(site, map, id, alias.revision, context.actor, postgres::NewEtag(), std::int64_t{kMaxAliases}));
  if (inserted.ok() && inserted->rows() == 0) {
    return ResourceExhausted("{} has {} aliases, as many as a map can have: delete one", NameOf(site, map),
                             kMaxAliases);
  }
  return CommitAlias(transaction, inserted, alias);
}

absl::StatusOr<MapAlias> MapAliasStore::RollBack(const CallContext& context, const SiteId& site, const MapId& map,
                                                 const MapAliasId& id, std::int64_t etag) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_ASSIGN_OR_RETURN(const MapAlias stored, LockAlias(transaction, site, map, id, etag));
  if (stored.previous_revision == 0) {
    return FailedPrecondition("{} has led to revision {} only: there is nothing to lead it back to",
                              NameOf(site, map, id), stored.revision);
  }
  return CommitAlias(transaction,
                     transaction.Execute(kRollBackAlias, Params(site, map, id, context.actor, postgres::NewEtag())),
                     stored);
}

absl::StatusOr<MapAlias> MapAliasStore::Get(const CallContext& context, const SiteId& site, const MapId& map,
                                            const MapAliasId& id) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result, ExecuteAlone(pool_, context, kSelectAlias, Params(site, map, id)));
  return postgres::ReadOne(result, ReadAlias, NameOf(site, map, id));
}

absl::StatusOr<std::vector<MapAlias>> MapAliasStore::List(const CallContext& context, const SiteId& site,
                                                          const MapId& map) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  transaction.Queue(kFindMapOfAlias, Params(site, map));
  transaction.Queue(kListAliases, Params(site, map));
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.FlushAndCommit());
  if (results[0].rows() == 0) return NotFound("{} does not exist", NameOf(site, map));
  return postgres::ReadRows(results[1], ReadAlias);
}

absl::Status MapAliasStore::Delete(const CallContext& context, const SiteId& site, const MapId& map,
                                   const MapAliasId& id, std::int64_t etag) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_RETURN_IF_ERROR(LockAlias(transaction, site, map, id, etag).status());
  transaction.Queue(kDeleteAlias, Params(site, map, id));
  postgres::QueueRevisionReview(transaction, {site, map});
  return WithContext(transaction.Commit(), NameOf(site, map, id));
}

}  // namespace enfilade::storage
