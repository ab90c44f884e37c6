// SPDX-License-Identifier: Apache-2.0
#include "storage/link_point_store.h"

#include "core/base/resource_name.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/graph/graph_change.h"
#include "storage/postgres/graph/link_point_changes.h"
#include "storage/postgres/graph/link_point_rows.h"
#include "storage/postgres/graph/placement.h"

namespace enfilade::storage {
namespace {

using postgres::ExecuteAlone;
using postgres::Params;
using postgres::RaiseGraphVersion;
using postgres::ResourceOf;
using postgres::Row;
using postgres::Statement;
using postgres::Transaction;

constexpr Statement kSelectLinkPoint{
    "reading the link point", "SELECT " ENFILADE_LINK_POINT_COLUMNS " FROM enfilade.link_points p" ENFILADE_JOIN_ANCHORS
                              " WHERE p.site_id = $1 AND p.link_point_id = $2 ORDER BY a.ordinal"};
constexpr Statement kFindLinkPointRequest{"looking for an earlier request",
                                          "SELECT link_point_id FROM enfilade.link_points"
                                          " WHERE site_id = $1 AND request_id = $2"};
// $3 = 0: whatever the etag is.
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

// Commits, with the link point as it is then.
absl::StatusOr<StoredLinkPoint> FinishChange(Transaction& transaction, const SiteId& site, const LinkPointId& id,
                                             std::int64_t version) {
  ENFILADE_RETURN_IF_ERROR(postgres::PlaceLinkPoint(transaction, site, version, id));
  transaction.Queue(kSelectLinkPoint, Params(site, id));
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.FlushAndCommit());
  return postgres::ReadLinkPoint(results.back(), site, id);
}

}  // namespace

absl::StatusOr<StoredLinkPoint> LinkPointStore::Create(const CallContext& context, const StoredLinkPoint& link_point,
                                                       const std::string& request_id) const {
  ENFILADE_RETURN_IF_ERROR(postgres::ValidateLinkPoint(link_point));
  const SiteId& site = link_point.site;
  const graph::LinkPoint& point = link_point.point;
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t version,
                            storage::postgres::RaiseGraphVersion(transaction, site, GraphCause::kLinkPointAdded,
                                                                 storage::postgres::ResourceOf(point.id)));
  if (!request_id.empty()) {  // the graph's lock makes this sure
    ENFILADE_ASSIGN_OR_RETURN(const auto earlier, transaction.Execute(kFindLinkPointRequest, Params(site, request_id)));
    if (earlier.rows() > 0) {
      Row row(earlier, 0);
      const LinkPointId id{std::string(row.Text())};
      ENFILADE_ASSIGN_OR_RETURN(const auto stored, transaction.Execute(kSelectLinkPoint, Params(site, id)));
      return postgres::ReadLinkPoint(stored, site, id);
    }
  }
  ENFILADE_RETURN_IF_ERROR(postgres::InsertLinkPoint(transaction, link_point, version, request_id));
  return FinishChange(transaction, site, point.id, version);
}

absl::StatusOr<StoredLinkPoint> LinkPointStore::AddAnchor(const CallContext& context, const SiteId& site,
                                                          const LinkPointId& id, std::int64_t etag,
                                                          const graph::Anchor& anchor, bool force) const {
  ENFILADE_RETURN_IF_ERROR(postgres::ValidateAnchors({anchor}));
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t version,
                            storage::postgres::RaiseGraphVersion(transaction, site, GraphCause::kLinkPointChanged,
                                                                 storage::postgres::ResourceOf(id)));
  ENFILADE_ASSIGN_OR_RETURN(const auto touched, transaction.Execute(kTouch, Params(site, id, etag, version, force)));
  if (touched.rows() == 0) return postgres::WhyUntouched(transaction, site, id);
  ENFILADE_ASSIGN_OR_RETURN(const auto present, transaction.Execute(kHasAnchor, Params(site, id, anchor.map)));
  if (present.rows() > 0) {
    return AlreadyExists("{} has an anchor in the map \"{}\" already: update it instead", NameOf(site, id),
                         anchor.map.value());
  }
  graph::LinkPoint point;
  point.id = id;
  point.anchors = {anchor};
  postgres::QueueAnchors(transaction, site, id, point.anchors);
  const auto stored = transaction.Flush();
  if (!stored.ok()) return postgres::ExplainLinkPoint(stored.status(), site, point);
  return FinishChange(transaction, site, id, version);
}

absl::StatusOr<StoredLinkPoint> LinkPointStore::Update(const CallContext& context,
                                                       const StoredLinkPoint& link_point) const {
  ENFILADE_RETURN_IF_ERROR(postgres::ValidateLinkPoint(link_point));
  const SiteId& site = link_point.site;
  const graph::LinkPoint& point = link_point.point;
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t version,
                            storage::postgres::RaiseGraphVersion(transaction, site, GraphCause::kLinkPointChanged,
                                                                 storage::postgres::ResourceOf(point.id)));
  ENFILADE_RETURN_IF_ERROR(postgres::UpdateLinkPoint(transaction, link_point, version));
  return FinishChange(transaction, site, point.id, version);
}

absl::StatusOr<StoredLinkPoint> LinkPointStore::SetSuspended(const CallContext& context, const SiteId& site,
                                                             const LinkPointId& id, std::int64_t etag,
                                                             bool suspended) const {
  const auto use = static_cast<std::int16_t>(suspended ? graph::LinkPointUse::kSuspended : graph::LinkPointUse::kUsed);
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t version,
                            storage::postgres::RaiseGraphVersion(transaction, site, GraphCause::kLinkPointChanged,
                                                                 storage::postgres::ResourceOf(id)));
  const auto changed = transaction.Execute(kSetUse, Params(site, id, etag, version, use));
  if (!changed.ok()) {
    graph::LinkPoint point;
    point.id = id;
    return postgres::ExplainLinkPoint(changed.status(), site, point);
  }
  if (changed->rows() == 0) return postgres::WhyUntouched(transaction, site, id);
  return FinishChange(transaction, site, id, version);
}

absl::Status LinkPointStore::Delete(const CallContext& context, const SiteId& site, const LinkPointId& id,
                                    std::int64_t etag) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_RETURN_IF_ERROR(storage::postgres::RaiseGraphVersion(transaction, site, GraphCause::kLinkPointRemoved,
                                                                storage::postgres::ResourceOf(id))
                               .status());
  ENFILADE_RETURN_IF_ERROR(postgres::RemoveLinkPoint(transaction, site, id, etag));
  return WithContext(transaction.Commit(), NameOf(site, id));
}

absl::StatusOr<StoredLinkPoint> LinkPointStore::Get(const CallContext& context, const SiteId& site,
                                                    const LinkPointId& id) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result,
                            storage::postgres::ExecuteAlone(pool_, context, kSelectLinkPoint, Params(site, id)));
  return postgres::ReadLinkPoint(result, site, id);
}

}  // namespace enfilade::storage
