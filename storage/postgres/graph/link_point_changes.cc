// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/graph/link_point_changes.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/resource_name.h"
#include "storage/graph/link_point_rules.h"
#include "storage/postgres/driver/etag.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/graph/graph_versions.h"
#include "storage/postgres/graph/link_point_rows.h"
#include "storage/postgres/graph/placement.h"

namespace enfilade::storage::postgres {
namespace {

constexpr Statement kInsertLinkPoint{
    "creating the link point",
    "INSERT INTO enfilade.link_points (site_id, link_point_id, kind, tag, direction_map_id,"
    " difficulty, environment, state, valid_until, forced, pinned, changed_version, request_id,"
    " request_sha256) VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14)"};
constexpr Statement kUpdateLinkPoint{"updating the link point",
                                     "UPDATE enfilade.link_points SET kind = $4, tag = $5, direction_map_id = $6,"
                                     " difficulty = $7, environment = $8, state = $9, valid_until = $10, forced = $11,"
                                     " pinned = $12, changed_version = $13, etag = $14, update_time = now()"
                                     " WHERE site_id = $1 AND link_point_id = $2 AND etag = $3 RETURNING etag"};
constexpr Statement kDeleteLinkPoint{"deleting the link point",
                                     "DELETE FROM enfilade.link_points WHERE site_id = $1 AND link_point_id = $2"
                                     " AND $3 IN (0, etag) RETURNING etag"};
// One statement for all anchors: the trigger that checks redundancy sees all of them.
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
// $3 = 0: any etag.
constexpr Statement kTouch{"updating the link point",
                           "UPDATE enfilade.link_points SET changed_version = $4, etag = $6,"
                           " update_time = now(), forced = forced OR $5"
                           " WHERE site_id = $1 AND link_point_id = $2 AND $3 IN (0, etag) RETURNING etag"};
constexpr Statement kSetUse{"changing the link point's use",
                            "UPDATE enfilade.link_points SET \"use\" = $5, changed_version = $4,"
                            " etag = $6, update_time = now()"
                            " WHERE site_id = $1 AND link_point_id = $2 AND $3 IN (0, etag) RETURNING etag"};
// The link point itself, and all that share two maps with it once it has anchors in the maps $3.
constexpr Statement kSelectNearby{
    "reading the link points of the same maps",
    "SELECT " ENFILADE_LINK_POINT_COLUMNS " FROM enfilade.link_points p" ENFILADE_JOIN_ANCHORS
    " WHERE p.site_id = $1 AND p.link_point_id IN (SELECT o.link_point_id FROM enfilade.link_point_anchors o"
    "   WHERE o.site_id = $1 AND o.map_id IN (SELECT u.map_id COLLATE \"C\" FROM unnest($3::text[]) u (map_id)"
    "     UNION SELECT map_id FROM enfilade.link_point_anchors WHERE site_id = $1 AND link_point_id = $2)"
    "   GROUP BY o.link_point_id HAVING count(*) > 1 OR o.link_point_id = $2)"
    " ORDER BY p.link_point_id, a.ordinal"};

std::optional<std::string_view> DirectionOf(const graph::LinkPoint& point) {
  return NullIfEmpty(point.direction.value());
}

std::int16_t EnvironmentOf(const StoredLinkPoint& link_point) {
  return link_point.environment ? static_cast<std::int16_t>(*link_point.environment) : std::int16_t{0};
}

std::optional<Timestamp> ValidUntilOf(const graph::LinkPoint& point) {
  if (!point.state_valid_until) return std::nullopt;
  return Timestamp{*point.state_valid_until};
}

// The resource of a link point in the graph's history.
std::string ResourceOf(const LinkPointId& id) { return "linkPoints/" + id.value(); }

void QueueAnchors(Transaction& transaction, const SiteId& site, const LinkPointId& id,
                  const std::vector<graph::Anchor>& anchors) {
  const AnchorArrays arrays(anchors);
  transaction.Queue(kPutAnchors, Params(site, id, arrays.maps, arrays.x, arrays.y, arrays.yaw, arrays.covariances));
}

absl::Status MapMissing(const SiteId& site, const LinkPointId& id, const std::vector<graph::Anchor>& anchors) {
  std::string maps;
  for (const graph::Anchor& anchor : anchors) maps += (maps.empty() ? "" : ", ") + anchor.map.value();
  return NotFound("{}: one of its maps does not exist: {}", NameOf(site, id), maps);
}

// An error of the schema in terms of the API.
absl::Status ExplainLinkPoint(const absl::Status& status, const SiteId& site, const graph::LinkPoint& point) {
  if (status.ok()) return status;
  const std::string constraint = ConstraintOf(status);
  const std::string name = NameOf(site, point.id);
  if (constraint == "link_points_redundant") {
    std::string message(status.message());
    message = message.substr(message.find(": ") + 2);
    return AlreadyExists("{}: {}. Use force if there really are two", name,
                         message.substr(0, message.rfind(" (SQLSTATE")));
  }
  if (constraint == "link_points_pkey") return AlreadyExists("{} exists already", name);
  if (constraint == "link_point_anchors_site_id_map_id_fkey") return MapMissing(site, point.id, point.anchors);
  return WithContext(status, name);
}

struct Nearby {
  std::optional<StoredLinkPoint> stored;  // the link point itself
  std::vector<StoredLinkPoint> others;
};

// Of a graph that the transaction has locked.
absl::StatusOr<Nearby> ReadNearby(Transaction& transaction, const SiteId& site, const LinkPointId& id,
                                  const std::vector<graph::Anchor>& anchors) {
  std::vector<std::string_view> maps;
  for (const graph::Anchor& anchor : anchors) maps.push_back(anchor.map.value());
  ENFILADE_ASSIGN_OR_RETURN(const Result result, transaction.Execute(kSelectNearby, Params(site, id, maps)));
  ENFILADE_ASSIGN_OR_RETURN(std::vector<StoredLinkPoint> link_points, ReadLinkPoints(result));
  Nearby nearby;
  for (StoredLinkPoint& link_point : link_points) {
    if (link_point.point.id == id) {
      nearby.stored = std::move(link_point);
    } else {
      nearby.others.push_back(std::move(link_point));
    }
  }
  return nearby;
}

// The same of an existing link point. NOT_FOUND; ABORTED unless `etag` is 0 or the stored one.
absl::StatusOr<Nearby> ReadNearbyExisting(Transaction& transaction, const SiteId& site, const LinkPointId& id,
                                          std::int64_t etag, const std::vector<graph::Anchor>& anchors) {
  ENFILADE_ASSIGN_OR_RETURN(Nearby nearby, ReadNearby(transaction, site, id, anchors));
  if (!nearby.stored) return NotFound("{} does not exist", NameOf(site, id));
  if (etag != 0 && etag != nearby.stored->etag) return StaleEtag(NameOf(site, id));
  return nearby;
}

constexpr Statement kCountMaps{"looking for the link point's maps",
                               "SELECT count(*) FROM enfilade.maps WHERE site_id = $1 AND map_id = ANY ($2)"};

// Why a link point with these anchors is refused: a map that does not exist comes before `redundant`.
absl::Status WhyRefused(Transaction& transaction, const SiteId& site, const LinkPointId& id,
                        const std::vector<graph::Anchor>& anchors, const absl::Status& redundant) {
  std::vector<std::string_view> maps;
  for (const graph::Anchor& anchor : anchors) maps.push_back(anchor.map.value());
  ENFILADE_ASSIGN_OR_RETURN(const Result counted, transaction.Execute(kCountMaps, Params(site, maps)));
  Row row(counted, 0);
  if (row.Int64() == static_cast<std::int64_t>(maps.size())) return redundant;
  return MapMissing(site, id, anchors);
}

// Executes what is queued, and places the link point.
absl::Status FlushAndPlace(Transaction& transaction, const StoredLinkPoint& link_point, std::int64_t version) {
  ENFILADE_RETURN_IF_ERROR(ExplainLinkPoint(transaction.Flush().status(), link_point.site, link_point.point));
  return PlaceLinkPoint(transaction, link_point.site, version, link_point.point);
}

}  // namespace

absl::Status InsertLinkPoint(Transaction& transaction, const StoredLinkPoint& link_point, const RequestId& request_id) {
  ENFILADE_RETURN_IF_ERROR(ValidateLinkPoint(link_point));
  const SiteId& site = link_point.site;
  StoredLinkPoint created = link_point;
  created.point.use = graph::LinkPointUse::kUsed;
  const graph::LinkPoint& point = created.point;
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t version,
                            RaiseGraphVersion(transaction, site, GraphCause::kLinkPointAdded, ResourceOf(point.id)));
  if (!point.is_candidate() && !created.forced) {
    ENFILADE_ASSIGN_OR_RETURN(const Nearby nearby, ReadNearby(transaction, site, point.id, point.anchors));
    if (nearby.stored) return AlreadyExists("{} exists already", NameOf(site, point.id));
    const absl::Status fits = CheckNotRedundant(created, AnchorChange::kAdded, nearby.others);
    if (!fits.ok()) return WhyRefused(transaction, site, point.id, point.anchors, fits);
  }
  transaction.Queue(kInsertLinkPoint,
                    Params(site, point.id, static_cast<std::int16_t>(point.kind), point.tag, DirectionOf(point),
                           std::int32_t{point.difficulty}, EnvironmentOf(created),
                           static_cast<std::int16_t>(point.state), ValidUntilOf(point), created.forced, point.pinned,
                           version, IdOrNull(request_id), DigestOrNull(request_id)));
  QueueAnchors(transaction, site, point.id, point.anchors);
  return FlushAndPlace(transaction, created, version);
}

absl::Status UpdateLinkPoint(Transaction& transaction, const StoredLinkPoint& link_point) {
  ENFILADE_RETURN_IF_ERROR(ValidateLinkPoint(link_point));
  const SiteId& site = link_point.site;
  const LinkPointId& id = link_point.point.id;
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t version,
                            RaiseGraphVersion(transaction, site, GraphCause::kLinkPointChanged, ResourceOf(id)));
  ENFILADE_ASSIGN_OR_RETURN(const Nearby nearby, ReadNearby(transaction, site, id, link_point.point.anchors));
  if (!nearby.stored) return NotFound("{} does not exist", NameOf(site, id));
  if (nearby.stored->etag != link_point.etag) return StaleEtag(NameOf(site, id));
  const auto applied = ApplyUpdate(*nearby.stored, link_point, nearby.others);
  if (!applied.ok()) return WhyRefused(transaction, site, id, link_point.point.anchors, applied.status());
  const StoredLinkPoint& changed = *applied;
  const graph::LinkPoint& point = changed.point;
  transaction.Queue(kUpdateLinkPoint, Params(site, id, changed.etag, static_cast<std::int16_t>(point.kind), point.tag,
                                             DirectionOf(point), std::int32_t{point.difficulty}, EnvironmentOf(changed),
                                             static_cast<std::int16_t>(point.state), ValidUntilOf(point),
                                             changed.forced, point.pinned, version, NewEtag()));
  std::vector<std::string_view> maps;
  for (const graph::Anchor& anchor : point.anchors) maps.push_back(anchor.map.value());
  transaction.Queue(kDropAnchors, Params(site, id, maps));
  QueueAnchors(transaction, site, id, point.anchors);
  return FlushAndPlace(transaction, changed, version);
}

absl::Status InsertAnchor(Transaction& transaction, const SiteId& site, const NewAnchor& added) {
  ENFILADE_RETURN_IF_ERROR(ValidateAnchors({added.anchor}));
  const LinkPointId& id = added.link_point;
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t version,
                            RaiseGraphVersion(transaction, site, GraphCause::kLinkPointChanged, ResourceOf(id)));
  ENFILADE_ASSIGN_OR_RETURN(const Nearby nearby, ReadNearbyExisting(transaction, site, id, added.etag, {added.anchor}));
  const auto changed = ApplyAnchor(*nearby.stored, added, nearby.others);
  if (!changed.ok()) return WhyRefused(transaction, site, id, {added.anchor}, changed.status());
  transaction.Queue(kTouch, Params(site, id, added.etag, version, added.force, NewEtag()));
  QueueAnchors(transaction, site, id, {added.anchor});
  return FlushAndPlace(transaction, *changed, version);
}

absl::Status SetSuspended(Transaction& transaction, const SiteId& site, const LinkPointId& id, std::int64_t etag,
                          bool suspended) {
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t version,
                            RaiseGraphVersion(transaction, site, GraphCause::kLinkPointChanged, ResourceOf(id)));
  ENFILADE_ASSIGN_OR_RETURN(const Nearby nearby, ReadNearbyExisting(transaction, site, id, etag, {}));
  ENFILADE_ASSIGN_OR_RETURN(const StoredLinkPoint changed, ApplySuspension(*nearby.stored, suspended, nearby.others));
  transaction.Queue(kSetUse, Params(site, id, etag, version, static_cast<std::int16_t>(changed.point.use), NewEtag()));
  return FlushAndPlace(transaction, changed, version);
}

absl::Status RemoveLinkPoint(Transaction& transaction, const SiteId& site, const LinkPointId& id, std::int64_t etag) {
  ENFILADE_RETURN_IF_ERROR(
      RaiseGraphVersion(transaction, site, GraphCause::kLinkPointRemoved, ResourceOf(id)).status());
  ENFILADE_ASSIGN_OR_RETURN(const auto deleted, transaction.Execute(kDeleteLinkPoint, Params(site, id, etag)));
  if (deleted.rows() == 0) {
    return ReadNearbyExisting(transaction, site, id, etag, {}).status();
  }
  QueueRemoval(transaction, site, id);
  return absl::OkStatus();
}

absl::Status ChangeLinkPoint(Transaction& transaction, const SiteId& site, const LinkPointChange& change) {
  if (const auto* creation = std::get_if<LinkPointCreation>(&change)) {
    return InsertLinkPoint(transaction, creation->link_point, "");
  }
  if (const auto* update = std::get_if<LinkPointUpdate>(&change)) {
    return UpdateLinkPoint(transaction, update->link_point);
  }
  if (const auto* suspension = std::get_if<LinkPointSuspension>(&change)) {
    return SetSuspended(transaction, site, suspension->link_point, suspension->etag, suspension->suspended);
  }
  const auto& deletion = std::get<LinkPointDeletion>(change);
  return RemoveLinkPoint(transaction, site, deletion.link_point, deletion.etag);
}

}  // namespace enfilade::storage::postgres
