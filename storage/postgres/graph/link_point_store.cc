// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/graph/link_point_store.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <variant>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/graph/graph_versions.h"
#include "storage/postgres/graph/link_point_changes.h"
#include "storage/postgres/graph/link_point_evidence.h"
#include "storage/postgres/graph/link_point_rows.h"
#include "storage/postgres/graph/link_point_search.h"

namespace enfilade::storage::postgres {
namespace {

constexpr Statement kSelectLinkPoint{
    "reading the link point", "SELECT " ENFILADE_LINK_POINT_COLUMNS " FROM enfilade.link_points p" ENFILADE_JOIN_ANCHORS
                              " WHERE p.site_id = $1 AND p.link_point_id = $2 ORDER BY a.ordinal"};
constexpr Statement kFindLinkPointRequest{"looking for an earlier request",
                                          "SELECT link_point_id" ENFILADE_SAME_REQUEST("$3") " FROM enfilade.link_points"
                                          " WHERE site_id = $1 AND request_id = $2"};
// Commits, and returns the link point.
absl::StatusOr<StoredLinkPoint> CommitAndRead(Transaction& transaction, const SiteId& site, const LinkPointId& id) {
  transaction.Queue(kSelectLinkPoint, Params(site, id));
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.FlushAndCommit());
  return ReadLinkPoint(results.back(), site, id);
}

// The link points that `changes` leave, each once, in the order of their first changes.
std::vector<LinkPointId> LeftBy(const std::vector<LinkPointChange>& changes) {
  std::vector<LinkPointId> left;
  for (const LinkPointChange& change : changes) {
    const LinkPointId& id = LinkPointOf(change);
    const auto known = std::find(left.begin(), left.end(), id);
    if (std::holds_alternative<LinkPointDeletion>(change)) {
      if (known != left.end()) left.erase(known);
    } else if (known == left.end()) {
      left.push_back(id);
    }
  }
  return left;
}

// What an earlier call with this request id has created. Locks the site's graph: no other call can create it now.
absl::StatusOr<std::optional<StoredLinkPoint>> FindCreated(Transaction& transaction, const SiteId& site,
                                                           const RequestId& request_id) {
  QueueGraphLock(transaction, site);
  ENFILADE_ASSIGN_OR_RETURN(
      const auto earlier,
      transaction.Execute(kFindLinkPointRequest, Params(site, request_id.value, DigestOrNull(request_id))));
  if (earlier.rows() == 0) return std::nullopt;
  Row row(earlier, 0);
  const LinkPointId id{std::string(row.Text())};
  ENFILADE_RETURN_IF_ERROR(CheckSameRequest(row.Bool()));
  ENFILADE_ASSIGN_OR_RETURN(const auto stored, transaction.Execute(kSelectLinkPoint, Params(site, id)));
  ENFILADE_ASSIGN_OR_RETURN(StoredLinkPoint created, ReadLinkPoint(stored, site, id));
  return std::optional<StoredLinkPoint>(std::move(created));
}

}  // namespace

absl::StatusOr<StoredLinkPoint> LinkPointStore::Create(const CallContext& context, const StoredLinkPoint& link_point,
                                                       const RequestId& request_id) const {
  ENFILADE_RETURN_IF_ERROR(ValidateLinkPoint(link_point));
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  if (!request_id.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(auto created, FindCreated(transaction, link_point.site, request_id));
    if (created) return *std::move(created);
  }
  ENFILADE_RETURN_IF_ERROR(InsertLinkPoint(transaction, link_point, request_id));
  return CommitAndRead(transaction, link_point.site, link_point.point.id);
}

absl::StatusOr<StoredLinkPoint> LinkPointStore::AddAnchor(const CallContext& context, const SiteId& site,
                                                          const NewAnchor& added) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_RETURN_IF_ERROR(InsertAnchor(transaction, site, added));
  return CommitAndRead(transaction, site, added.link_point);
}

absl::StatusOr<StoredLinkPoint> LinkPointStore::Update(const CallContext& context,
                                                       const StoredLinkPoint& link_point) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_RETURN_IF_ERROR(UpdateLinkPoint(transaction, link_point));
  return CommitAndRead(transaction, link_point.site, link_point.point.id);
}

absl::StatusOr<StoredLinkPoint> LinkPointStore::SetSuspended(const CallContext& context, const SiteId& site,
                                                             const LinkPointId& id, std::int64_t etag,
                                                             bool suspended) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_RETURN_IF_ERROR(postgres::SetSuspended(transaction, site, id, etag, suspended));
  return CommitAndRead(transaction, site, id);
}

absl::Status LinkPointStore::Delete(const CallContext& context, const SiteId& site, const LinkPointId& id,
                                    std::int64_t etag) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_RETURN_IF_ERROR(RemoveLinkPoint(transaction, site, id, etag));
  return WithContext(transaction.Commit(), NameOf(site, id));
}

absl::StatusOr<ChangedLinkPoints> LinkPointStore::Change(const CallContext& context, const SiteId& site,
                                                         const std::vector<LinkPointChange>& changes) const {
  if (changes.empty()) return InvalidArgument("changes is empty: expected at least one change");
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  for (std::size_t i = 0; i < changes.size(); ++i) {
    ENFILADE_RETURN_IF_ERROR(
        WithContext(ChangeLinkPoint(transaction, site, changes[i]), fmt::format("changes[{}]", i)));
  }
  const std::vector<LinkPointId> left = LeftBy(changes);
  for (const LinkPointId& id : left) transaction.Queue(kSelectLinkPoint, Params(site, id));
  transaction.Queue(kSelectGraphVersion, Params(site));
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.FlushAndCommit());
  ChangedLinkPoints changed;
  ENFILADE_ASSIGN_OR_RETURN(changed.graph_version, ReadGraphVersion(results.back()));
  const std::size_t first = results.size() - 1 - left.size();
  for (std::size_t i = 0; i < left.size(); ++i) {
    ENFILADE_ASSIGN_OR_RETURN(StoredLinkPoint link_point, ReadLinkPoint(results[first + i], site, left[i]));
    changed.link_points.push_back(std::move(link_point));
  }
  return changed;
}

absl::StatusOr<StoredLinkPoint> LinkPointStore::Get(const CallContext& context, const SiteId& site,
                                                    const LinkPointId& id) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result, ExecuteAlone(pool_, context, kSelectLinkPoint, Params(site, id)));
  return ReadLinkPoint(result, site, id);
}

absl::StatusOr<std::vector<StoredLinkPoint>> LinkPointStore::List(const CallContext& context, const SiteId& site,
                                                                  const LinkPointFilter& filter,
                                                                  const PageRequest& page) const {
  return ListLinkPoints(pool_, context, site, filter, page);
}

absl::StatusOr<FoundLinkPoints> LinkPointStore::Find(const CallContext& context, const SiteId& site,
                                                     const LinkPointQuery& query) const {
  return FindLinkPoints(pool_, context, site, query);
}

absl::StatusOr<std::vector<StoredLinkPoint>> LinkPointStore::ListUnplaced(const CallContext& context,
                                                                          const SiteId& site, int limit) const {
  return ListUnplacedLinkPoints(pool_, context, site, limit);
}

absl::Status LinkPointStore::PutEvidence(const CallContext& context, const SiteId& site,
                                         const Evidence& evidence) const {
  return postgres::PutEvidence(pool_, context, site, evidence);
}

absl::StatusOr<std::vector<Evidence>> LinkPointStore::ListEvidence(const CallContext& context, const SiteId& site,
                                                                   const std::vector<LinkPointId>& link_points) const {
  return postgres::ListEvidence(pool_, context, site, link_points);
}

}  // namespace enfilade::storage::postgres
