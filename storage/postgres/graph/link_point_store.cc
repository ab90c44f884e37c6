// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/graph/link_point_store.h"

#include "core/base/resource_name.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/graph/graph_versions.h"
#include "storage/postgres/graph/link_point_changes.h"
#include "storage/postgres/graph/link_point_evidence.h"
#include "storage/postgres/graph/link_point_rows.h"
#include "storage/postgres/graph/link_point_search.h"
#include "storage/postgres/graph/placement.h"

namespace enfilade::storage::postgres {
namespace {

constexpr Statement kSelectLinkPoint{
    "reading the link point", "SELECT " ENFILADE_LINK_POINT_COLUMNS " FROM enfilade.link_points p" ENFILADE_JOIN_ANCHORS
                              " WHERE p.site_id = $1 AND p.link_point_id = $2 ORDER BY a.ordinal"};
constexpr Statement kFindLinkPointRequest{"looking for an earlier request",
                                          "SELECT link_point_id FROM enfilade.link_points"
                                          " WHERE site_id = $1 AND request_id = $2"};
// $3 = 0: any etag.
constexpr Statement kTouch{"updating the link point",
                           "UPDATE enfilade.link_points SET changed_version = $4, etag = nextval('enfilade.etags'),"
                           " update_time = now(), forced = forced OR $5"
                           " WHERE site_id = $1 AND link_point_id = $2 AND $3 IN (0, etag) RETURNING etag"};
constexpr Statement kSetUse{"changing the link point's use",
                            "UPDATE enfilade.link_points SET \"use\" = $5, changed_version = $4,"
                            " etag = nextval('enfilade.etags'), update_time = now()"
                            " WHERE site_id = $1 AND link_point_id = $2 AND $3 IN (0, etag) RETURNING etag"};
constexpr Statement kHasAnchor{"looking for the anchor",
                               "SELECT true FROM enfilade.link_point_anchors"
                               " WHERE site_id = $1 AND link_point_id = $2 AND map_id = $3"};

// Places the link point, commits, and returns it.
absl::StatusOr<StoredLinkPoint> FinishChange(Transaction& transaction, const SiteId& site, const LinkPointId& id,
                                             std::int64_t version) {
  ENFILADE_RETURN_IF_ERROR(PlaceLinkPoint(transaction, site, version, id));
  transaction.Queue(kSelectLinkPoint, Params(site, id));
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.FlushAndCommit());
  return ReadLinkPoint(results.back(), site, id);
}

}  // namespace

absl::StatusOr<StoredLinkPoint> LinkPointStore::Create(const CallContext& context, const StoredLinkPoint& link_point,
                                                       const std::string& request_id) const {
  ENFILADE_RETURN_IF_ERROR(ValidateLinkPoint(link_point));
  const SiteId& site = link_point.site;
  const graph::LinkPoint& point = link_point.point;
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t version,
                            RaiseGraphVersion(transaction, site, GraphCause::kLinkPointAdded, ResourceOf(point.id)));
  if (!request_id.empty()) {  // the graph is locked: no other call can create it now
    ENFILADE_ASSIGN_OR_RETURN(const auto earlier, transaction.Execute(kFindLinkPointRequest, Params(site, request_id)));
    if (earlier.rows() > 0) {
      Row row(earlier, 0);
      const LinkPointId id{std::string(row.Text())};
      ENFILADE_ASSIGN_OR_RETURN(const auto stored, transaction.Execute(kSelectLinkPoint, Params(site, id)));
      return ReadLinkPoint(stored, site, id);
    }
  }
  ENFILADE_RETURN_IF_ERROR(InsertLinkPoint(transaction, link_point, version, request_id));
  return FinishChange(transaction, site, point.id, version);
}

absl::StatusOr<StoredLinkPoint> LinkPointStore::AddAnchor(const CallContext& context, const SiteId& site,
                                                          const NewAnchor& added) const {
  const LinkPointId& id = added.link_point;
  ENFILADE_RETURN_IF_ERROR(ValidateAnchors({added.anchor}));
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t version,
                            RaiseGraphVersion(transaction, site, GraphCause::kLinkPointChanged, ResourceOf(id)));
  ENFILADE_ASSIGN_OR_RETURN(const auto touched,
                            transaction.Execute(kTouch, Params(site, id, added.etag, version, added.force)));
  if (touched.rows() == 0) return WhyUnchanged(transaction, site, id);
  ENFILADE_ASSIGN_OR_RETURN(const auto present, transaction.Execute(kHasAnchor, Params(site, id, added.anchor.map)));
  if (present.rows() > 0) {
    return AlreadyExists("{} already has an anchor in the map \"{}\": update it instead", NameOf(site, id),
                         added.anchor.map.value());
  }
  graph::LinkPoint point;
  point.id = id;
  point.anchors = {added.anchor};
  QueueAnchors(transaction, site, id, point.anchors);
  const auto stored = transaction.Flush();
  if (!stored.ok()) return ExplainLinkPoint(stored.status(), site, point);
  return FinishChange(transaction, site, id, version);
}

absl::StatusOr<StoredLinkPoint> LinkPointStore::Update(const CallContext& context,
                                                       const StoredLinkPoint& link_point) const {
  ENFILADE_RETURN_IF_ERROR(ValidateLinkPoint(link_point));
  const SiteId& site = link_point.site;
  const graph::LinkPoint& point = link_point.point;
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t version,
                            RaiseGraphVersion(transaction, site, GraphCause::kLinkPointChanged, ResourceOf(point.id)));
  ENFILADE_RETURN_IF_ERROR(UpdateLinkPoint(transaction, link_point, version));
  return FinishChange(transaction, site, point.id, version);
}

absl::StatusOr<StoredLinkPoint> LinkPointStore::SetSuspended(const CallContext& context, const SiteId& site,
                                                             const LinkPointId& id, std::int64_t etag,
                                                             bool suspended) const {
  const auto use = static_cast<std::int16_t>(suspended ? graph::LinkPointUse::kSuspended : graph::LinkPointUse::kUsed);
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t version,
                            RaiseGraphVersion(transaction, site, GraphCause::kLinkPointChanged, ResourceOf(id)));
  const auto changed = transaction.Execute(kSetUse, Params(site, id, etag, version, use));
  if (!changed.ok()) {
    graph::LinkPoint point;
    point.id = id;
    return ExplainLinkPoint(changed.status(), site, point);
  }
  if (changed->rows() == 0) return WhyUnchanged(transaction, site, id);
  return FinishChange(transaction, site, id, version);
}

absl::Status LinkPointStore::Delete(const CallContext& context, const SiteId& site, const LinkPointId& id,
                                    std::int64_t etag) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_RETURN_IF_ERROR(
      RaiseGraphVersion(transaction, site, GraphCause::kLinkPointRemoved, ResourceOf(id)).status());
  ENFILADE_RETURN_IF_ERROR(RemoveLinkPoint(transaction, site, id, etag));
  return WithContext(transaction.Commit(), NameOf(site, id));
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
