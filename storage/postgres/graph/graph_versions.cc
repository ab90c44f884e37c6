// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/graph/graph_versions.h"

#include "core/base/resource_name.h"
#include "fmt/format.h"
#include "storage/postgres/driver/rows.h"

namespace enfilade::storage::postgres {
namespace {

constexpr Statement kLockGraph{"locking the graph",
                               "SELECT graph_version FROM enfilade.site_graphs WHERE site_id = $1 FOR UPDATE"};
constexpr Statement kRaiseVersion{"raising the graph's version",
                                  "INSERT INTO enfilade.site_graphs AS g (site_id, graph_version, cause, resource)"
                                  " VALUES ($1, 1, $2, $3) ON CONFLICT (site_id) DO UPDATE"
                                  " SET graph_version = g.graph_version + 1, cause = $2, resource = $3"
                                  " RETURNING graph_version"};
constexpr Statement kRecordRemoval{
    "recording a removal",
    "INSERT INTO enfilade.graph_removals (site_id, kind, id, removed_version)"
    " SELECT site_id, $2, $3, graph_version FROM enfilade.site_graphs WHERE site_id = $1"
    " ON CONFLICT (site_id, kind, id) DO UPDATE SET removed_version = excluded.removed_version"};
constexpr std::int16_t kRemovedMap = 1;
constexpr std::int16_t kRemovedLinkPoint = 2;

}  // namespace

void NotifyOfGraph(Transaction& transaction, const SiteId& site, std::int64_t version) {
  transaction.NotifyAtCommit(ENFILADE_GRAPH_CHANNEL, fmt::format("{} {}", site.value(), version));
}

absl::Status NotifyOfPresentGraph(Transaction& transaction, const SiteId& site) {
  ENFILADE_ASSIGN_OR_RETURN(const Result selected, transaction.Execute(kSelectGraphVersion, Params(site)));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t version, ReadGraphVersion(selected));
  NotifyOfGraph(transaction, site, version);
  return absl::OkStatus();
}

absl::StatusOr<std::int64_t> ReadGraphVersion(const Result& result) {
  if (result.rows() == 0) return 0;
  return ReadOne(
      result, [](Row& row) { return row.Int64(); }, "the graph");
}

void QueueGraphLock(Transaction& transaction, const SiteId& site) { transaction.Queue(kLockGraph, Params(site)); }

absl::StatusOr<std::int64_t> LockGraph(Transaction& transaction, const SiteId& site) {
  ENFILADE_ASSIGN_OR_RETURN(const auto locked, transaction.Execute(kLockGraph, Params(site)));
  return ReadGraphVersion(locked);
}

absl::StatusOr<std::int64_t> RaiseGraphVersion(Transaction& transaction, const SiteId& site, GraphCause cause,
                                               const std::string& resource) {
  const auto raised = transaction.Execute(kRaiseVersion, Params(site, static_cast<std::int16_t>(cause), resource));
  if (SqlStateOf(raised.status()) == "23503") return NotFound("{} does not exist", NameOf(site));
  ENFILADE_RETURN_IF_ERROR(raised.status());
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t version,
                            ReadOne(
                                *raised, [](Row& row) { return row.Int64(); }, NameOf(site)));
  NotifyOfGraph(transaction, site, version);
  return version;
}

void QueueRemoval(Transaction& transaction, const SiteId& site, const MapId& map) {
  transaction.Queue(kRecordRemoval, Params(site, kRemovedMap, map));
}

void QueueRemoval(Transaction& transaction, const SiteId& site, const LinkPointId& link_point) {
  transaction.Queue(kRecordRemoval, Params(site, kRemovedLinkPoint, link_point));
}

}  // namespace enfilade::storage::postgres
