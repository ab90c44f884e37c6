// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/graph/link_point_changes.h"

#include <optional>

#include "core/base/resource_name.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/graph/graph_versions.h"
#include "storage/postgres/graph/link_point_rows.h"

namespace enfilade::storage::postgres {
namespace {

constexpr Statement kInsertLinkPoint{
    "creating the link point",
    "INSERT INTO enfilade.link_points (site_id, link_point_id, kind, tag, direction_map_id,"
    " difficulty, environment, state, valid_until, forced, changed_version, request_id)"
    " VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12)"};
constexpr Statement kUpdateLinkPoint{"updating the link point",
                                     "UPDATE enfilade.link_points SET kind = $4, tag = $5, direction_map_id = $6,"
                                     " difficulty = $7, environment = $8, state = $9, valid_until = $10, forced = $11,"
                                     " changed_version = $12, etag = nextval('enfilade.etags'), update_time = now()"
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
constexpr Statement kExists{"looking for the link point",
                            "SELECT true FROM enfilade.link_points WHERE site_id = $1 AND link_point_id = $2"};
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

}  // namespace

absl::Status InsertLinkPoint(Transaction& transaction, const StoredLinkPoint& link_point, std::int64_t version,
                             const std::string& request_id) {
  const SiteId& site = link_point.site;
  const graph::LinkPoint& point = link_point.point;
  transaction.Queue(kInsertLinkPoint, Params(site, point.id, static_cast<std::int16_t>(point.kind), point.tag,
                                             DirectionOf(point), std::int32_t{point.difficulty},
                                             EnvironmentOf(link_point), static_cast<std::int16_t>(point.state),
                                             ValidUntilOf(point), link_point.forced, version, NullIfEmpty(request_id)));
  QueueAnchors(transaction, site, point.id, point.anchors);
  return ExplainLinkPoint(transaction.Flush().status(), site, point);
}

absl::Status UpdateLinkPoint(Transaction& transaction, const StoredLinkPoint& link_point, std::int64_t version) {
  const SiteId& site = link_point.site;
  const graph::LinkPoint& point = link_point.point;
  const auto updated = transaction.Execute(
      kUpdateLinkPoint,
      Params(site, point.id, link_point.etag, static_cast<std::int16_t>(point.kind), point.tag, DirectionOf(point),
             std::int32_t{point.difficulty}, EnvironmentOf(link_point), static_cast<std::int16_t>(point.state),
             ValidUntilOf(point), link_point.forced, version));
  if (!updated.ok()) return ExplainLinkPoint(updated.status(), site, point);
  if (updated->rows() == 0) return WhyUnchanged(transaction, site, point.id);
  std::vector<std::string_view> maps;
  for (const graph::Anchor& anchor : point.anchors) maps.push_back(anchor.map.value());
  transaction.Queue(kDropAnchors, Params(site, point.id, maps));
  QueueAnchors(transaction, site, point.id, point.anchors);
  return ExplainLinkPoint(transaction.Flush().status(), site, point);
}

absl::Status RemoveLinkPoint(Transaction& transaction, const SiteId& site, const LinkPointId& id, std::int64_t etag) {
  ENFILADE_ASSIGN_OR_RETURN(const auto deleted, transaction.Execute(kDeleteLinkPoint, Params(site, id, etag)));
  if (deleted.rows() == 0) return WhyUnchanged(transaction, site, id);
  QueueRemoval(transaction, site, id);
  return absl::OkStatus();
}

void QueueAnchors(Transaction& transaction, const SiteId& site, const LinkPointId& id,
                  const std::vector<graph::Anchor>& anchors) {
  std::vector<std::string_view> maps;
  std::vector<double> x, y, yaw, covariances;
  for (const graph::Anchor& anchor : anchors) {
    maps.push_back(anchor.map.value());
    x.push_back(anchor.T_map_place.x);
    y.push_back(anchor.T_map_place.y);
    yaw.push_back(anchor.T_map_place.yaw);
    const std::vector<double> row = ToRow(anchor.covariance);
    covariances.insert(covariances.end(), row.begin(), row.end());
  }
  transaction.Queue(kPutAnchors, Params(site, id, maps, x, y, yaw, covariances));
}

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
  if (constraint == "link_point_anchors_site_id_map_id_fkey") {
    std::string maps;
    for (const graph::Anchor& anchor : point.anchors) maps += (maps.empty() ? "" : ", ") + anchor.map.value();
    return NotFound("{}: one of its maps does not exist: {}", name, maps);
  }
  return WithContext(status, name);
}

absl::Status WhyUnchanged(Transaction& transaction, const SiteId& site, const LinkPointId& id) {
  ENFILADE_ASSIGN_OR_RETURN(const auto found, transaction.Execute(kExists, Params(site, id)));
  if (found.rows() == 0) return NotFound("{} does not exist", NameOf(site, id));
  return StaleEtag(NameOf(site, id));
}

}  // namespace enfilade::storage::postgres
