// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/graph/placement.h"

#include <string>
#include <utility>

#include "core/graph/placement.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/graph/link_point_rows.h"

namespace enfilade::storage::postgres {
namespace {

constexpr Statement kSelectUnplacedAt{
    "looking for link points to place",
    "SELECT " ENFILADE_LINK_POINT_COLUMNS " FROM enfilade.link_points p" ENFILADE_JOIN_ANCHORS
    " WHERE p.site_id = $1 AND p.position IS NULL AND p.link_point_id IN (SELECT link_point_id"
    "   FROM enfilade.link_point_anchors WHERE site_id = $1 AND map_id = ANY ($2))"
    " ORDER BY p.link_point_id, a.ordinal"};
constexpr Statement kSelectPlaces{"reading maps' places",
                                  "SELECT map_id, x, y, yaw, covariance FROM enfilade.graph_maps"
                                  " WHERE site_id = $1 AND map_id = ANY ($2) AND x IS NOT NULL"};
// The last array has nine numbers for each covariance.
constexpr Statement kPlaceMaps{
    "placing maps",
    "UPDATE enfilade.graph_maps m SET changed_version = $2, x = u.x, y = u.y, yaw = u.yaw,"
    " covariance = ($7::float8[])[u.n::integer * 9 - 8 : u.n::integer * 9]"
    " FROM unnest($3::text[], $4::float8[], $5::float8[], $6::float8[]) WITH ORDINALITY AS u (id, x, y, yaw, n)"
    " WHERE m.site_id = $1 AND m.map_id = u.id"};
constexpr Statement kPlaceLinkPoints{
    "placing link points",
    "UPDATE enfilade.link_points p SET changed_version = $2, position = ST_MakePoint(u.x, u.y), yaw = u.yaw,"
    " world_covariance = ($7::float8[])[u.n::integer * 9 - 8 : u.n::integer * 9]"
    " FROM unnest($3::text[], $4::float8[], $5::float8[], $6::float8[]) WITH ORDINALITY AS u (id, x, y, yaw, n)"
    " WHERE p.site_id = $1 AND p.link_point_id = u.id"};

// The columns of places, as arrays.
class Columns {
 public:
  void Add(const std::string& id, const PoseWithCovariance& place) {
    ids_.push_back(id);
    x_.push_back(place.pose.x);
    y_.push_back(place.pose.y);
    yaw_.push_back(place.pose.yaw);
    const std::vector<double> row = ToRow(place.covariance);
    covariances_.insert(covariances_.end(), row.begin(), row.end());
  }
  void QueueTo(Transaction& transaction, const Statement& statement, const SiteId& site, std::int64_t version) const {
    if (!ids_.empty()) transaction.Queue(statement, Params(site, version, ids_, x_, y_, yaw_, covariances_));
  }

 private:
  std::vector<std::string_view> ids_;
  std::vector<double> x_, y_, yaw_, covariances_;
};

absl::Status ReadPlaces(Transaction& transaction, const SiteId& site, const std::vector<MapId>& maps,
                        graph::Placement& placement) {
  if (maps.empty()) return absl::OkStatus();
  std::vector<std::string_view> ids;
  for (const MapId& map : maps) ids.push_back(map.value());
  ENFILADE_ASSIGN_OR_RETURN(const Result result, transaction.Execute(kSelectPlaces, Params(site, ids)));
  for (int i = 0; i < result.rows(); ++i) {
    Row row(result, i);
    const MapId map{std::string(row.Text())};
    PoseWithCovariance T_world_map;
    T_world_map.pose = {row.Double(), row.Double(), row.Double()};
    T_world_map.covariance = ReadCovariance(row);
    ENFILADE_RETURN_IF_ERROR(row.status());
    placement.SetPlace(map, T_world_map);
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<graph::LinkPoint>> ReadUnplacedAt(Transaction& transaction, const SiteId& site,
                                                             const std::vector<MapId>& maps) {
  std::vector<std::string_view> ids;
  for (const MapId& map : maps) ids.push_back(map.value());
  ENFILADE_ASSIGN_OR_RETURN(const Result result, transaction.Execute(kSelectUnplacedAt, Params(site, ids)));
  ENFILADE_ASSIGN_OR_RETURN(std::vector<StoredLinkPoint> stored, ReadLinkPoints(result));
  std::vector<graph::LinkPoint> link_points;
  for (StoredLinkPoint& link_point : stored) link_points.push_back(std::move(link_point.point));
  return link_points;
}

}  // namespace

absl::Status PlaceLinkPoint(Transaction& transaction, const SiteId& site, std::int64_t version,
                            const graph::LinkPoint& link_point) {
  graph::Placement placement;
  std::vector<graph::LinkPoint> next = {link_point};
  while (!next.empty()) {
    ENFILADE_RETURN_IF_ERROR(ReadPlaces(transaction, site, placement.UnknownMapsOf(next), placement));
    const std::vector<MapId> reached = placement.Visit(next);
    if (reached.empty()) break;
    ENFILADE_ASSIGN_OR_RETURN(next, ReadUnplacedAt(transaction, site, reached));
  }
  std::vector<MapPose> maps;
  for (const auto& [map, place] : placement.maps()) maps.push_back({map, place});
  std::vector<LinkPointPose> link_points;
  for (const auto& [id, place] : placement.link_points()) link_points.push_back({id, place});
  QueuePlaces(transaction, site, version, maps, link_points);
  return absl::OkStatus();
}

void QueuePlaces(Transaction& transaction, const SiteId& site, std::int64_t version, const std::vector<MapPose>& maps,
                 const std::vector<LinkPointPose>& link_points) {
  Columns map_columns, link_point_columns;
  for (const MapPose& map : maps) map_columns.Add(map.map.value(), map.T_world_map);
  for (const LinkPointPose& point : link_points) link_point_columns.Add(point.link_point.value(), point.T_world_place);
  map_columns.QueueTo(transaction, kPlaceMaps, site, version);
  link_point_columns.QueueTo(transaction, kPlaceLinkPoints, site, version);
}

}  // namespace enfilade::storage::postgres
