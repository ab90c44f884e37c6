// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/maps/map_store.h"

#include "core/base/environment.h"
#include "core/base/resource_name.h"
#include "storage/postgres/driver/etag.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/driver/wkb.h"
#include "storage/postgres/graph/graph_versions.h"
#include "storage/postgres/sessions/session_deletion.h"

namespace enfilade::storage::postgres {
namespace {

#define ENFILADE_MAP_COLUMNS                                                                             \
  "site_id, map_id, display_name, level, environment, slam_profile, ST_AsBinary(outline, 'NDR'), state," \
  " pinned, current_revision, etag, create_time, update_time"

constexpr Statement kInsertMap{
    "creating the map",
    "INSERT INTO enfilade.maps (site_id, map_id, display_name, level, environment, slam_profile, outline, pinned,"
    " request_id, request_sha256) VALUES ($1, $2, $3, $4, $5, $6, ST_GeomFromWKB($7, 0), $8, $9, $10) "
    "RETURNING " ENFILADE_MAP_COLUMNS};
constexpr Statement kFindMapRequest{"looking for an earlier request",
                                    "SELECT " ENFILADE_MAP_COLUMNS ENFILADE_SAME_REQUEST(
                                        "$3") " FROM enfilade.maps WHERE site_id = $1 AND request_id = $2"};
constexpr Statement kSelectMap{"reading the map", "SELECT " ENFILADE_MAP_COLUMNS
                                                  " FROM enfilade.maps WHERE site_id = $1 AND map_id ="
                                                  "   (SELECT r.map_id FROM enfilade.resolve_map($1, $2) r)"};
constexpr Statement kMapExists{
    "looking for the map",
    "SELECT etag FROM enfilade.maps WHERE site_id = $1 AND map_id = $2 AND redirect_map_id IS NULL"};
constexpr Statement kSelectByDisplayName{"looking for the map", "SELECT " ENFILADE_MAP_COLUMNS
                                                                " FROM enfilade.maps WHERE site_id = $1 AND map_id ="
                                                                "   (SELECT r.map_id FROM enfilade.maps m,"
                                                                "     enfilade.resolve_map(m.site_id, m.map_id) r"
                                                                "   WHERE m.site_id = $1 AND m.display_name = $2)"};
constexpr Statement kListMaps{"listing maps", "SELECT " ENFILADE_MAP_COLUMNS
                                              " FROM enfilade.maps WHERE site_id = $1 AND map_id > $2"
                                              " AND redirect_map_id IS NULL ORDER BY map_id LIMIT $3"};
constexpr Statement kUpdateMap{"updating the map",
                               "UPDATE enfilade.maps SET display_name = $4, level = $5, environment = $6,"
                               " slam_profile = $7, outline = ST_GeomFromWKB($8, 0),"
                               " pinned = $9, etag = $10, update_time = now()"
                               " WHERE site_id = $1 AND map_id = $2 AND etag = $3 AND redirect_map_id IS NULL"
                               " RETURNING " ENFILADE_MAP_COLUMNS};
constexpr Statement kFindSessions{
    "looking for the map's sessions",
    "SELECT session_id FROM enfilade.sessions WHERE site_id = $1 AND map_id = $2 ORDER BY session_id"};
constexpr Statement kFindLinkPoints{
    "looking for the map's link points",
    "SELECT p.link_point_id FROM enfilade.link_point_anchors a JOIN enfilade.link_points p"
    " ON p.site_id = a.site_id AND p.link_point_id = a.link_point_id"
    " WHERE a.site_id = $1 AND a.map_id = $2 ORDER BY p.link_point_id"};
constexpr Statement kMarkChanged{"marking the map as changed",
                                 "UPDATE enfilade.graph_maps SET changed_version = $3"
                                 " WHERE site_id = $1 AND map_id = $2"};
// Link points that join fewer than two maps without it are deleted with it.
constexpr Statement kFindOrphans{"looking for link points that go with the map",
                                 "SELECT link_point_id FROM enfilade.link_points"
                                 " WHERE site_id = $1 AND link_point_id = ANY ($2) AND anchor_count <= 2"};
constexpr Statement kDeleteOrphans{"deleting the map's link points",
                                   "DELETE FROM enfilade.link_points WHERE site_id = $1 AND link_point_id = ANY ($2)"};
constexpr Statement kDeleteAnchors{"deleting the map's anchors",
                                   "DELETE FROM enfilade.link_point_anchors WHERE site_id = $1 AND map_id = $2"};
constexpr Statement kLeaveMap{"changing the link points that are left",
                              "UPDATE enfilade.link_points SET changed_version = $3,"
                              " direction_map_id = nullif(direction_map_id, $4), etag = $5,"
                              " update_time = now() WHERE site_id = $1 AND link_point_id = ANY ($2)"};
// Keeps the world frame: the oldest of the other maps with a pose in it becomes the root.
constexpr Statement kLeaveRoot{
    "choosing another root map",
    "UPDATE enfilade.site_graphs SET root_map_id = (SELECT m.map_id FROM enfilade.maps m"
    "   JOIN enfilade.graph_maps g ON g.site_id = m.site_id AND g.map_id = m.map_id"
    "   WHERE m.site_id = $1 AND m.map_id <> $2 ORDER BY g.x IS NULL, m.create_time, m.map_id LIMIT 1)"
    " WHERE site_id = $1 AND root_map_id = $2"};
// A root without a pose starts a new world frame.
constexpr Statement kPlaceRoot{
    "placing the root map",
    "UPDATE enfilade.graph_maps m SET x = 0, y = 0, yaw = 0, covariance = array_fill(0::double precision, '{9}'),"
    " changed_version = g.graph_version FROM enfilade.site_graphs g"
    " WHERE g.site_id = $1 AND m.site_id = $1 AND m.map_id = g.root_map_id AND m.x IS NULL"};
// What ties the map to plans ends with it: one that is made again under its id is another map.
constexpr Statement kLeavePriorMaps{"taking the map from prior maps",
                                    "UPDATE enfilade.prior_maps SET aligned_maps = array_remove(aligned_maps, $2),"
                                    " joined_maps = array_remove(joined_maps, $2), etag = $3, update_time = now()"
                                    " WHERE site_id = $1 AND aligned_maps @> ARRAY[$2]"};
constexpr Statement kLockMap{"locking the map",
                             "SELECT etag FROM enfilade.maps"
                             " WHERE site_id = $1 AND map_id = $2 AND redirect_map_id IS NULL FOR UPDATE"};
constexpr Statement kDeleteMap{"deleting the map", "DELETE FROM enfilade.maps WHERE site_id = $1 AND map_id = $2"};

struct MapRow {
  Map map;
  std::string outline;
};

MapRow ReadMapRow(Row& row) {
  Map map;
  map.site = SiteId(std::string(row.Text()));
  map.id = MapId(std::string(row.Text()));
  map.display_name = row.Text();
  map.level = row.Int32();
  map.environment = static_cast<Environment>(row.Int16());
  map.slam_profile = row.Text();
  const std::string outline(row.OptionalBytes().value_or(""));
  map.state = static_cast<MapState>(row.Int16());
  map.pinned = row.Bool();
  map.current_revision = row.Int64();
  map.etag = row.Int64();
  map.create_time = row.Time();
  map.update_time = row.Time();
  return {std::move(map), outline};
}

absl::StatusOr<Map> Decode(MapRow row) {
  if (row.outline.empty()) return std::move(row.map);
  auto outline = DecodePolygon(row.outline);
  if (!outline.ok()) return WithContext(outline.status(), NameOf(row.map.site, row.map.id));
  row.map.outline = *std::move(outline);
  return std::move(row.map);
}

absl::StatusOr<Map> ReadMap(const Result& result, const std::string& name) {
  ENFILADE_ASSIGN_OR_RETURN(MapRow row, ReadOne(result, ReadMapRow, name));
  return Decode(std::move(row));
}

absl::StatusOr<std::vector<Map>> ReadMaps(const Result& result) {
  ENFILADE_ASSIGN_OR_RETURN(std::vector<MapRow> rows, ReadRows(result, ReadMapRow));
  std::vector<Map> maps;
  for (MapRow& row : rows) {
    ENFILADE_ASSIGN_OR_RETURN(Map map, Decode(std::move(row)));
    maps.push_back(std::move(map));
  }
  return maps;
}

std::optional<Bytes> BytesOrNull(const std::string& bytes) {
  if (bytes.empty()) return std::nullopt;
  return Bytes{bytes};
}

absl::Status Explain(const absl::Status& status, const Map& map) {
  const std::string constraint = ConstraintOf(status);
  if (constraint == "maps_site_id_display_name_key") {
    return AlreadyExists("{} has a map with the display name \"{}\" already", NameOf(map.site), map.display_name);
  }
  if (constraint == "maps_outline_check") {
    return InvalidArgument("outline is not a simple polygon: its sides must not cross or touch one another");
  }
  if (absl::IsAlreadyExists(status)) return AlreadyExists("{} exists already", NameOf(map.site, map.id));
  if (SqlStateOf(status) == "23503") return NotFound("{} does not exist", NameOf(map.site));
  return WithContext(status, NameOf(map.site, map.id));
}

absl::Status TakeFromGraph(Transaction& transaction, const SiteId& site, const MapId& map, std::int64_t version,
                           const std::vector<std::string>& link_points) {
  const std::vector<std::string_view> ids(link_points.begin(), link_points.end());
  ENFILADE_ASSIGN_OR_RETURN(const auto found, transaction.Execute(kFindOrphans, Params(site, ids)));
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<std::string> orphans,
                            ReadRows(found, [](Row& row) { return std::string(row.Text()); }));
  for (const std::string& orphan : orphans) QueueRemoval(transaction, site, LinkPointId(orphan));
  const std::vector<std::string_view> orphan_ids(orphans.begin(), orphans.end());
  transaction.Queue(kDeleteOrphans, Params(site, orphan_ids));
  transaction.Queue(kDeleteAnchors, Params(site, map));
  transaction.Queue(kLeaveMap, Params(site, ids, version, map, NewEtag()));
  transaction.Queue(kLeaveRoot, Params(site, map));
  transaction.Queue(kPlaceRoot, Params(site));
  QueueRemoval(transaction, site, map);
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Map> MapStore::Create(const CallContext& context, const Map& map, const RequestId& request_id) const {
  ENFILADE_RETURN_IF_ERROR(ValidateOutline(map));
  const std::string outline = EncodePolygon(map.outline);
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  QueueGraphLock(transaction, map.site);
  transaction.Queue(
      kInsertMap,
      Params(map.site, map.id, map.display_name, std::int32_t{map.level}, static_cast<std::int16_t>(map.environment),
             map.slam_profile, BytesOrNull(outline), map.pinned, IdOrNull(request_id), DigestOrNull(request_id)));
  const auto inserted = transaction.Flush();
  if (inserted.ok()) {
    ENFILADE_RETURN_IF_ERROR(NotifyOfPresentGraph(transaction, map.site));
    ENFILADE_RETURN_IF_ERROR(WithContext(transaction.Commit(), NameOf(map.site, map.id)));
    return ReadMap(inserted->back(), NameOf(map.site, map.id));
  }
  if (absl::IsAlreadyExists(inserted.status()) && !request_id.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(
        const auto earlier,
        ExecuteAlone(pool_, context, kFindMapRequest, Params(map.site, request_id.value, DigestOrNull(request_id))));
    if (earlier.rows() > 0) {
      ENFILADE_ASSIGN_OR_RETURN(MapRow row, ReadRequested(earlier, ReadMapRow, NameOf(map.site, map.id)));
      return Decode(std::move(row));
    }
  }
  return Explain(inserted.status(), map);
}

absl::StatusOr<Map> MapStore::Get(const CallContext& context, const SiteId& site, const MapId& map) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result, ExecuteAlone(pool_, context, kSelectMap, Params(site, map)));
  return ReadMap(result, NameOf(site, map));
}

absl::StatusOr<Map> MapStore::GetByDisplayName(const CallContext& context, const SiteId& site,
                                               const std::string& display_name) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result,
                            ExecuteAlone(pool_, context, kSelectByDisplayName, Params(site, display_name)));
  return ReadMap(result, fmt::format("a map \"{}\" in {}", display_name, NameOf(site)));
}

absl::StatusOr<std::vector<Map>> MapStore::List(const CallContext& context, const SiteId& site,
                                                const PageRequest& page) const {
  ENFILADE_ASSIGN_OR_RETURN(
      const auto result,
      ExecuteAlone(pool_, context, kListMaps, Params(site, page.after, static_cast<std::int64_t>(page.limit))));
  return ReadMaps(result);
}

absl::StatusOr<Map> MapStore::Update(const CallContext& context, const Map& map) const {
  ENFILADE_RETURN_IF_ERROR(ValidateOutline(map));
  const std::string outline = EncodePolygon(map.outline);
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_ASSIGN_OR_RETURN(
      const std::int64_t version,
      RaiseGraphVersion(transaction, map.site, GraphCause::kMapChanged, "maps/" + map.id.value()));
  const auto updated =
      transaction.Execute(kUpdateMap, Params(map.site, map.id, map.etag, map.display_name, std::int32_t{map.level},
                                             static_cast<std::int16_t>(map.environment), map.slam_profile,
                                             BytesOrNull(outline), map.pinned, NewEtag()));
  if (!updated.ok()) return Explain(updated.status(), map);
  if (updated->rows() == 0) {
    ENFILADE_ASSIGN_OR_RETURN(const auto stored, transaction.Execute(kMapExists, Params(map.site, map.id)));
    if (stored.rows() == 0) return NotFound("{} does not exist", NameOf(map.site, map.id));
    return StaleEtag(NameOf(map.site, map.id));
  }
  transaction.Queue(kMarkChanged, Params(map.site, map.id, version));
  ENFILADE_RETURN_IF_ERROR(WithContext(transaction.Commit(), NameOf(map.site, map.id)));
  return ReadMap(*updated, NameOf(map.site, map.id));
}

absl::Status MapStore::Delete(const CallContext& context, const SiteId& site, const MapId& map, std::int64_t etag,
                              bool force) const {
  const auto ids_of = [](const Result& result) {
    return ReadRows(result, [](Row& row) { return std::string(row.Text()); });
  };
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t version,
                            RaiseGraphVersion(transaction, site, GraphCause::kMapRemoved, "maps/" + map.value()));
  transaction.Queue(kFindSessions, Params(site, map));
  transaction.Queue(kFindLinkPoints, Params(site, map));
  ENFILADE_ASSIGN_OR_RETURN(const auto found, transaction.Flush());
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<std::string> sessions, ids_of(found[0]));
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<std::string> link_points, ids_of(found[1]));
  const std::vector<std::string_view> session_views(sessions.begin(), sessions.end());
  if (force) transaction.Queue(kRevokeLeases, Params(site, session_views));
  ENFILADE_ASSIGN_OR_RETURN(const auto locked, transaction.Execute(kLockMap, Params(site, map)));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t stored_etag,
                            ReadOne(
                                locked, [](Row& row) { return row.Int64(); }, NameOf(site, map)));
  if (etag != 0 && etag != stored_etag) return StaleEtag(NameOf(site, map));
  if (!force) ENFILADE_RETURN_IF_ERROR(ValidateUnused(site, map, {sessions, link_points}));
  ENFILADE_RETURN_IF_ERROR(TakeFromGraph(transaction, site, map, version, link_points));
  transaction.Queue(kMarkSessionsDeleted, Params(site, session_views));
  transaction.Queue(kLeavePriorMaps, Params(site, map, NewEtag()));
  transaction.Queue(kDeleteMap, Params(site, map));
  const absl::Status committed = transaction.Commit();
  if (SqlStateOf(committed) == "23503") {
    return Aborted("{} got another session during the deletion: try again", NameOf(site, map));
  }
  return WithContext(committed, NameOf(site, map));
}

}  // namespace enfilade::storage::postgres
