#include "storage/link_point_store.h"

#include "storage/postgres/graph_change.h"
#include "storage/postgres/link_point_rows.h"
#include "storage/postgres/names.h"
#include "storage/postgres/placement.h"
#include "storage/postgres/rows.h"

namespace enfilade {
namespace {

using postgres::ExecuteAlone;
using postgres::NameOf;
using postgres::Params;
using postgres::RaiseGraphVersion;
using postgres::Row;
using postgres::Statement;
using postgres::Timestamp;
using postgres::Transaction;

constexpr Statement kSelect{"reading the link point",
                            "SELECT " ENFILADE_LINK_POINT_COLUMNS " FROM enfilade.link_points p" ENFILADE_JOIN_ANCHORS
                            " WHERE p.site_id = $1 AND p.link_point_id = $2 ORDER BY a.ordinal"};
constexpr Statement kFindRequest{"looking for an earlier request",
                                 "SELECT link_point_id FROM enfilade.link_points"
                                 " WHERE site_id = $1 AND request_id = $2"};
constexpr Statement kInsert{"creating the link point",
                            "INSERT INTO enfilade.link_points (site_id, link_point_id, kind, tag, direction_map_id,"
                            " difficulty, environment, state, valid_until, forced, changed_version, request_id)"
                            " VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12)"};
constexpr Statement kUpdate{"updating the link point",
                            "UPDATE enfilade.link_points SET kind = $4, tag = $5, direction_map_id = $6,"
                            " difficulty = $7, environment = $8, state = $9, valid_until = $10, forced = $11,"
                            " changed_version = $12, etag = nextval('enfilade.etags'), update_time = now()"
                            " WHERE site_id = $1 AND link_point_id = $2 AND etag = $3 RETURNING etag"};
// $3 = 0: whatever the etag is.
constexpr Statement kTouch{"updating the link point",
                           "UPDATE enfilade.link_points SET changed_version = $4, etag = nextval('enfilade.etags'),"
                           " update_time = now(), forced = forced OR $5"
                           " WHERE site_id = $1 AND link_point_id = $2 AND $3 IN (0, etag) RETURNING etag"};
constexpr Statement kSetUse{"changing the link point's use",
                            "UPDATE enfilade.link_points SET \"use\" = $5, changed_version = $4,"
                            " etag = nextval('enfilade.etags'), update_time = now()"
                            " WHERE site_id = $1 AND link_point_id = $2 AND $3 IN (0, etag) RETURNING etag"};
constexpr Statement kDelete{"deleting the link point",
                            "DELETE FROM enfilade.link_points WHERE site_id = $1 AND link_point_id = $2"
                            " AND $3 IN (0, etag) RETURNING etag"};
// One statement for all, so that the check for redundancy sees all.
constexpr Statement kPutAnchors{
    "storing the anchors",
    "INSERT INTO enfilade.link_point_anchors AS a"
    " (site_id, link_point_id, map_id, ordinal, x, y, yaw, covariance)"
    " SELECT $1, $2, u.map_id, (SELECT coalesce(max(ordinal), 0) FROM enfilade.link_point_anchors"
    "   WHERE site_id = $1 AND link_point_id = $2) + u.n, u.x, u.y, u.yaw,"
    "   ($7::float8[])[u.n::integer * 9 - 8 : u.n::integer * 9]"
    " FROM unnest($3::text[], $4::float8[], $5::float8[], $6::float8[]) WITH ORDINALITY AS u (map_id, x, y, yaw, n)"
    " ON CONFLICT (site_id, link_point_id, map_id) DO UPDATE"
    " SET x = excluded.x, y = excluded.y, yaw = excluded.yaw, covariance = excluded.covariance"
    " WHERE (a.x, a.y, a.yaw, a.covariance) IS DISTINCT FROM"
    "   (excluded.x, excluded.y, excluded.yaw, excluded.covariance)"};
constexpr Statement kDropAnchors{"removing anchors",
                                 "DELETE FROM enfilade.link_point_anchors"
                                 " WHERE site_id = $1 AND link_point_id = $2 AND NOT map_id = ANY ($3)"};
constexpr Statement kHasAnchor{"looking for the anchor",
                               "SELECT true FROM enfilade.link_point_anchors"
                               " WHERE site_id = $1 AND link_point_id = $2 AND map_id = $3"};

std::optional<std::string_view> DirectionOf(const LinkPoint& point) {
  return postgres::NullIfEmpty(point.direction.value());
}

std::int16_t EnvironmentOf(const StoredLinkPoint& link_point) {
  return link_point.environment ? static_cast<std::int16_t>(*link_point.environment) : std::int16_t{0};
}

std::optional<Timestamp> ValidUntilOf(const LinkPoint& point) {
  if (!point.state_valid_until) return std::nullopt;
  return Timestamp{*point.state_valid_until};
}

absl::Status Validate(const StoredLinkPoint& link_point) {
  ENFILADE_RETURN_IF_ERROR(postgres::ValidateAnchors(link_point.point.anchors));
  const MapId& direction = link_point.point.direction;
  if (!direction.empty() && !link_point.point.FindAnchor(direction)) {
    return InvalidArgument("direction is the map \"{}\": the link point has no anchor in it", direction.value());
  }
  return absl::OkStatus();
}

void QueueAnchors(Transaction& transaction, const SiteId& site, const LinkPointId& id,
                  const std::vector<Anchor>& anchors) {
  std::vector<std::string_view> maps;
  std::vector<double> x, y, yaw, covariances;
  for (const Anchor& anchor : anchors) {
    maps.push_back(anchor.map.value());
    x.push_back(anchor.T_map_place.x);
    y.push_back(anchor.T_map_place.y);
    yaw.push_back(anchor.T_map_place.yaw);
    const std::vector<double> row = postgres::ToRow(anchor.covariance);
    covariances.insert(covariances.end(), row.begin(), row.end());
  }
  transaction.Queue(kPutAnchors, Params(site, id, maps, x, y, yaw, covariances));
}

// What the schema says, in the words of the API.
absl::Status Explain(const absl::Status& status, const SiteId& site, const LinkPoint& point) {
  const std::string constraint = postgres::ConstraintOf(status);
  const std::string name = NameOf(site, point.id);
  if (constraint == "link_points_redundant") {
    std::string message(status.message());
    message = message.substr(message.find(": ") + 2);
    return AlreadyExists("{}: {}. Use force where there are two indeed", name,
                         message.substr(0, message.rfind(" (SQLSTATE")));
  }
  if (constraint == "link_points_pkey") return AlreadyExists("{} exists already", name);
  if (constraint == "link_point_anchors_site_id_map_id_fkey") {
    std::string maps;
    for (const Anchor& anchor : point.anchors) maps += (maps.empty() ? "" : ", ") + anchor.map.value();
    return NotFound("{}: one of its maps does not exist: {}", name, maps);
  }
  return WithContext(status, name);
}

// Commits, with the link point as it is then.
absl::StatusOr<StoredLinkPoint> FinishChange(Transaction& transaction, const SiteId& site, const LinkPointId& id,
                                             std::int64_t version) {
  ENFILADE_RETURN_IF_ERROR(postgres::PlaceLinkPoint(transaction, site, version, id));
  transaction.Queue(kSelect, Params(site, id));
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.FlushAndCommit());
  return postgres::ReadLinkPoint(results.back(), site, id);
}

// Why a change that asks for an etag touched no row.
absl::Status WhyNone(Transaction& transaction, const SiteId& site, const LinkPointId& id) {
  ENFILADE_ASSIGN_OR_RETURN(const auto found, transaction.Execute(kSelect, Params(site, id)));
  if (found.rows() == 0) return NotFound("{} does not exist", NameOf(site, id));
  return postgres::StaleEtag(NameOf(site, id));
}

std::string ResourceOf(const LinkPointId& id) { return "linkPoints/" + id.value(); }

}  // namespace

absl::StatusOr<StoredLinkPoint> LinkPointStore::Create(const CallContext& context, const StoredLinkPoint& link_point,
                                                       const std::string& request_id) const {
  ENFILADE_RETURN_IF_ERROR(Validate(link_point));
  const SiteId& site = link_point.site;
  const LinkPoint& point = link_point.point;
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t version,
                            RaiseGraphVersion(transaction, site, GraphCause::kLinkPointAdded, ResourceOf(point.id)));
  if (!request_id.empty()) {  // the graph's lock makes this sure
    ENFILADE_ASSIGN_OR_RETURN(const auto earlier, transaction.Execute(kFindRequest, Params(site, request_id)));
    if (earlier.rows() > 0) {
      Row row(earlier, 0);
      const LinkPointId id{std::string(row.Text())};
      ENFILADE_ASSIGN_OR_RETURN(const auto stored, transaction.Execute(kSelect, Params(site, id)));
      return postgres::ReadLinkPoint(stored, site, id);
    }
  }
  transaction.Queue(
      kInsert, Params(site, point.id, static_cast<std::int16_t>(point.kind), point.tag, DirectionOf(point),
                      std::int32_t{point.difficulty}, EnvironmentOf(link_point), static_cast<std::int16_t>(point.state),
                      ValidUntilOf(point), link_point.forced, version, postgres::NullIfEmpty(request_id)));
  QueueAnchors(transaction, site, point.id, point.anchors);
  const auto stored = transaction.Flush();
  if (!stored.ok()) return Explain(stored.status(), site, point);
  return FinishChange(transaction, site, point.id, version);
}

absl::StatusOr<StoredLinkPoint> LinkPointStore::AddAnchor(const CallContext& context, const SiteId& site,
                                                          const LinkPointId& id, std::int64_t etag,
                                                          const Anchor& anchor, bool force) const {
  ENFILADE_RETURN_IF_ERROR(postgres::ValidateAnchors({anchor}));
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t version,
                            RaiseGraphVersion(transaction, site, GraphCause::kLinkPointChanged, ResourceOf(id)));
  ENFILADE_ASSIGN_OR_RETURN(const auto touched, transaction.Execute(kTouch, Params(site, id, etag, version, force)));
  if (touched.rows() == 0) return WhyNone(transaction, site, id);
  ENFILADE_ASSIGN_OR_RETURN(const auto present, transaction.Execute(kHasAnchor, Params(site, id, anchor.map)));
  if (present.rows() > 0) {
    return AlreadyExists("{} has an anchor in the map \"{}\" already: update it instead", NameOf(site, id),
                         anchor.map.value());
  }
  LinkPoint point;
  point.id = id;
  point.anchors = {anchor};
  QueueAnchors(transaction, site, id, point.anchors);
  const auto stored = transaction.Flush();
  if (!stored.ok()) return Explain(stored.status(), site, point);
  return FinishChange(transaction, site, id, version);
}

absl::StatusOr<StoredLinkPoint> LinkPointStore::Update(const CallContext& context,
                                                       const StoredLinkPoint& link_point) const {
  ENFILADE_RETURN_IF_ERROR(Validate(link_point));
  const SiteId& site = link_point.site;
  const LinkPoint& point = link_point.point;
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t version,
                            RaiseGraphVersion(transaction, site, GraphCause::kLinkPointChanged, ResourceOf(point.id)));
  const auto updated = transaction.Execute(
      kUpdate, Params(site, point.id, link_point.etag, static_cast<std::int16_t>(point.kind), point.tag,
                      DirectionOf(point), std::int32_t{point.difficulty}, EnvironmentOf(link_point),
                      static_cast<std::int16_t>(point.state), ValidUntilOf(point), link_point.forced, version));
  if (!updated.ok()) return Explain(updated.status(), site, point);
  if (updated->rows() == 0) return WhyNone(transaction, site, point.id);
  std::vector<std::string_view> maps;
  for (const Anchor& anchor : point.anchors) maps.push_back(anchor.map.value());
  transaction.Queue(kDropAnchors, Params(site, point.id, maps));
  QueueAnchors(transaction, site, point.id, point.anchors);
  const auto stored = transaction.Flush();
  if (!stored.ok()) return Explain(stored.status(), site, point);
  return FinishChange(transaction, site, point.id, version);
}

absl::StatusOr<StoredLinkPoint> LinkPointStore::SetSuspended(const CallContext& context, const SiteId& site,
                                                             const LinkPointId& id, std::int64_t etag,
                                                             bool suspended) const {
  const auto use = static_cast<std::int16_t>(suspended ? LinkPointUse::kSuspended : LinkPointUse::kUsed);
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t version,
                            RaiseGraphVersion(transaction, site, GraphCause::kLinkPointChanged, ResourceOf(id)));
  const auto changed = transaction.Execute(kSetUse, Params(site, id, etag, version, use));
  if (!changed.ok()) {
    LinkPoint point;
    point.id = id;
    return Explain(changed.status(), site, point);
  }
  if (changed->rows() == 0) return WhyNone(transaction, site, id);
  return FinishChange(transaction, site, id, version);
}

absl::Status LinkPointStore::Delete(const CallContext& context, const SiteId& site, const LinkPointId& id,
                                    std::int64_t etag) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_RETURN_IF_ERROR(
      RaiseGraphVersion(transaction, site, GraphCause::kLinkPointRemoved, ResourceOf(id)).status());
  ENFILADE_ASSIGN_OR_RETURN(const auto deleted, transaction.Execute(kDelete, Params(site, id, etag)));
  if (deleted.rows() == 0) return WhyNone(transaction, site, id);
  postgres::QueueRemoval(transaction, site, id);
  return WithContext(transaction.Commit(), NameOf(site, id));
}

absl::StatusOr<StoredLinkPoint> LinkPointStore::Get(const CallContext& context, const SiteId& site,
                                                    const LinkPointId& id) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result, ExecuteAlone(pool_, context, kSelect, Params(site, id)));
  return postgres::ReadLinkPoint(result, site, id);
}

}  // namespace enfilade
