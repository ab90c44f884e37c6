// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/graph/placement.h"

#include <map>
#include <optional>
#include <set>

#include "core/base/resource_name.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/graph/link_point_rows.h"

namespace enfilade::storage::postgres {
namespace {

constexpr Statement kSelectWithMaps{
    "reading link points to be placed",
    "SELECT " ENFILADE_LINK_POINT_COLUMNS " FROM enfilade.link_points p" ENFILADE_JOIN_ANCHORS
    " WHERE p.site_id = $1 AND p.link_point_id = $2 ORDER BY p.link_point_id, a.ordinal"};
constexpr Statement kSelectUnplacedAt{
    "looking for link points to be placed",
    "SELECT " ENFILADE_LINK_POINT_COLUMNS " FROM enfilade.link_points p" ENFILADE_JOIN_ANCHORS
    " WHERE p.site_id = $1 AND p.position IS NULL AND p.link_point_id IN (SELECT link_point_id"
    "   FROM enfilade.link_point_anchors WHERE site_id = $1 AND map_id = ANY ($2))"
    " ORDER BY p.link_point_id, a.ordinal"};
constexpr Statement kSelectPlaces{"reading maps' places",
                                  "SELECT map_id, x, y, yaw, covariance FROM enfilade.graph_maps"
                                  " WHERE site_id = $1 AND map_id = ANY ($2) AND x IS NOT NULL"};
// A covariance is nine numbers of the last array.
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

using Places = std::map<MapId, PoseWithCovariance>;

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

absl::Status ReadPlaces(Transaction& transaction, const SiteId& site, const std::vector<StoredLinkPoint>& link_points,
                        Places& places) {
  std::set<std::string_view> ids;
  for (const StoredLinkPoint& link_point : link_points) {
    for (const graph::Anchor& anchor : link_point.point.anchors) {
      if (!places.contains(anchor.map)) ids.insert(anchor.map.value());
    }
  }
  if (ids.empty()) return absl::OkStatus();
  const std::vector<std::string_view> wanted(ids.begin(), ids.end());
  ENFILADE_ASSIGN_OR_RETURN(const Result result, transaction.Execute(kSelectPlaces, Params(site, wanted)));
  for (int i = 0; i < result.rows(); ++i) {
    Row row(result, i);
    const MapId map{std::string(row.Text())};
    PoseWithCovariance& place = places[map];
    place.pose = {row.Double(), row.Double(), row.Double()};
    place.covariance = ReadCovariance(row);
    ENFILADE_RETURN_IF_ERROR(row.status());
  }
  return absl::OkStatus();
}

std::optional<PoseWithCovariance> BestPlace(const graph::LinkPoint& point, const Places& places) {
  std::optional<PoseWithCovariance> best;
  for (const graph::Anchor& anchor : point.anchors) {
    const auto map = places.find(anchor.map);
    if (map == places.end()) continue;
    const PoseWithCovariance place = Compose(map->second, {anchor.T_map_place, anchor.covariance});
    if (!best || place.covariance.topLeftCorner<2, 2>().trace() < best->covariance.topLeftCorner<2, 2>().trace()) {
      best = place;
    }
  }
  return best;
}

}  // namespace

absl::Status PlaceLinkPoint(Transaction& transaction, const SiteId& site, std::int64_t version,
                            const LinkPointId& link_point) {
  ENFILADE_ASSIGN_OR_RETURN(const Result first, transaction.Execute(kSelectWithMaps, Params(site, link_point)));
  ENFILADE_ASSIGN_OR_RETURN(std::vector<StoredLinkPoint> waiting, ReadLinkPoints(first));
  Places places;
  std::vector<MapPose> new_maps;
  std::map<LinkPointId, PoseWithCovariance> placed;
  while (!waiting.empty()) {
    ENFILADE_RETURN_IF_ERROR(ReadPlaces(transaction, site, waiting, places));
    std::vector<std::string_view> reached;
    for (const StoredLinkPoint& next : waiting) {
      if (placed.contains(next.point.id)) continue;
      const auto place = BestPlace(next.point, places);
      if (!place) continue;
      placed.emplace(next.point.id, *place);
      if (next.point.use != graph::LinkPointUse::kUsed) continue;
      for (const graph::Anchor& anchor : next.point.anchors) {
        const auto [map, is_new] = places.try_emplace(anchor.map);
        if (!is_new) continue;
        map->second = Compose(*place, Inverse(PoseWithCovariance{anchor.T_map_place, anchor.covariance}));
        new_maps.push_back({anchor.map, map->second});
        reached.push_back(map->first.value());
      }
    }
    if (reached.empty()) break;
    ENFILADE_ASSIGN_OR_RETURN(const Result found, transaction.Execute(kSelectUnplacedAt, Params(site, reached)));
    ENFILADE_ASSIGN_OR_RETURN(waiting, ReadLinkPoints(found));
  }
  std::vector<LinkPointPose> link_points;
  for (const auto& [id, place] : placed) link_points.push_back({id, place});
  QueuePlaces(transaction, site, version, new_maps, link_points);
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
