// SPDX-License-Identifier: Apache-2.0
#include "storage/maps/map_area_store.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string_view>
#include <utility>

#include "core/base/resource_name.h"
#include "storage/postgres/driver/etag.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/driver/wkb.h"
#include "storage/postgres/maps/layer_rows.h"

namespace enfilade::storage {
namespace {

using postgres::Bytes;
using postgres::ExecuteAlone;
using postgres::Params;
using postgres::Result;
using postgres::Row;
using postgres::Statement;
using postgres::Timestamp;
using postgres::Transaction;

#define ENFILADE_MAP_AREA_COLUMNS                                                                                    \
  "site_id, map_id, area_id, display_name, kind, ST_AsBinary(outline, 'NDR'), robot_types, speed_limit, valid_from," \
  " valid_until, etag, create_time, update_time"
// The map that an id leads to.
#define ENFILADE_MAP_OF_AREA "map_id = (SELECT r.map_id FROM enfilade.resolve_map($1, $2) r)"

// New areas of a map follow one another, so that they can be counted.
constexpr Statement kLockMapOfArea{"locking the map",
                                   "SELECT FROM enfilade.maps WHERE site_id = $1 AND map_id = $2"
                                   " AND redirect_map_id IS NULL FOR NO KEY UPDATE"};
constexpr Statement kCountAreas{"counting the map's areas",
                                "SELECT count(*) FROM enfilade.map_areas WHERE site_id = $1 AND map_id = $2"};
constexpr std::size_t kNamedLinkPoints = 10;
constexpr Statement kFindCoveredLinkPoints{
    "looking for link points in the area",
    "SELECT a.link_point_id FROM enfilade.link_point_anchors a WHERE a.site_id = $1 AND a.map_id = $2"
    " AND ST_Intersects(ST_GeomFromWKB($3, 0), ST_MakePoint(a.x, a.y)) ORDER BY a.link_point_id LIMIT 11"};
constexpr Statement kInsertMapArea{
    "creating the area",
    "INSERT INTO enfilade.map_areas (site_id, map_id, area_id, display_name, kind, outline, robot_types, speed_limit,"
    " valid_from, valid_until, etag, request_id, request_sha256)"
    " VALUES ($1, $2, $3, $4, $5, ST_GeomFromWKB($6, 0), $7, $8, $9, $10, $11, $12, $13)"
    " RETURNING " ENFILADE_MAP_AREA_COLUMNS};
constexpr Statement kFindMapAreaRequest{"looking for an earlier request",
                                        "SELECT " ENFILADE_MAP_AREA_COLUMNS ENFILADE_SAME_REQUEST(
                                            "$3") " FROM enfilade.map_areas WHERE site_id = $1 AND request_id = $2"};
constexpr Statement kSelectMapArea{
    "reading the area", "SELECT " ENFILADE_MAP_AREA_COLUMNS
                        " FROM enfilade.map_areas WHERE site_id = $1 AND " ENFILADE_MAP_OF_AREA " AND area_id = $3"};
constexpr Statement kListMapAreas{"listing areas",
                                  "SELECT " ENFILADE_MAP_AREA_COLUMNS
                                  " FROM enfilade.map_areas WHERE site_id = $1 AND " ENFILADE_MAP_OF_AREA
                                  " AND area_id > $3 ORDER BY area_id LIMIT $4"};
constexpr Statement kMapOfAreasExists{"looking for the map",
                                      "SELECT FROM enfilade.maps WHERE site_id = $1 AND map_id = $2"};
constexpr Statement kListMapAreasOfKind{"listing areas",
                                        "SELECT " ENFILADE_MAP_AREA_COLUMNS
                                        " FROM enfilade.map_areas WHERE site_id = $1 AND map_id = $2 AND kind = $3"
                                        " ORDER BY area_id"};
constexpr Statement kUpdateMapArea{
    "updating the area",
    "UPDATE enfilade.map_areas SET display_name = $5, kind = $6, outline = ST_GeomFromWKB($7, 0), robot_types = $8,"
    " speed_limit = $9, valid_from = $10, valid_until = $11, etag = $12, update_time = now()"
    " WHERE site_id = $1 AND map_id = $2 AND area_id = $3 AND ($4 = 0 OR etag = $4)"
    " RETURNING " ENFILADE_MAP_AREA_COLUMNS};
constexpr Statement kMapAreaExists{
    "looking for the area", "SELECT FROM enfilade.map_areas WHERE site_id = $1 AND map_id = $2 AND area_id = $3"};
constexpr Statement kDeleteMapArea{"deleting the area",
                                   "DELETE FROM enfilade.map_areas"
                                   " WHERE site_id = $1 AND map_id = $2 AND area_id = $3 AND ($4 = 0 OR etag = $4)"};

struct MapAreaRow {
  MapArea area;
  std::string outline;
};

MapAreaRow ReadMapAreaRow(Row& row) {
  MapAreaRow read;
  MapArea& stored = read.area;
  stored.site = SiteId(std::string(row.Text()));
  stored.map = MapId(std::string(row.Text()));
  stored.id = MapAreaId(std::string(row.Text()));
  areas::MapArea& area = stored.area;
  area.display_name = row.Text();
  area.kind = static_cast<areas::AreaKind>(row.Int16());
  read.outline = row.Bytes();
  area.robot_types = row.OptionalTexts();
  area.speed_limit_mps = row.Double();
  area.valid_from = row.OptionalTime();
  area.valid_until = row.OptionalTime();
  stored.etag = row.Int64();
  stored.create_time = row.Time();
  stored.update_time = row.Time();
  return read;
}

std::string NameOfArea(const MapArea& area) { return NameOf(area.site, area.map, area.id); }

absl::StatusOr<MapArea> DecodeMapArea(MapAreaRow row) {
  auto outline = postgres::DecodePolygon(row.outline);
  if (!outline.ok()) return WithContext(outline.status(), NameOfArea(row.area));
  row.area.area.outline = *std::move(outline);
  return std::move(row.area);
}

absl::StatusOr<MapArea> ReadMapArea(const Result& result, const std::string& name) {
  ENFILADE_ASSIGN_OR_RETURN(MapAreaRow row, postgres::ReadOne(result, ReadMapAreaRow, name));
  return DecodeMapArea(std::move(row));
}

absl::StatusOr<std::vector<MapArea>> ReadMapAreas(const Result& result) {
  ENFILADE_ASSIGN_OR_RETURN(std::vector<MapAreaRow> rows, postgres::ReadRows(result, ReadMapAreaRow));
  std::vector<MapArea> areas;
  areas.reserve(rows.size());
  for (MapAreaRow& row : rows) {
    ENFILADE_ASSIGN_OR_RETURN(MapArea area, DecodeMapArea(std::move(row)));
    areas.push_back(std::move(area));
  }
  return areas;
}

std::optional<Timestamp> TimestampOrNull(const std::optional<TimeNs>& time) {
  if (!time) return std::nullopt;
  return Timestamp{*time};
}

// A keep-out area over a link point closes it.
bool MayCloseLinkPoints(const MapArea& area, bool force) {
  return area.area.kind == areas::AreaKind::kKeepOut && !force;
}

absl::Status ExplainCovered(const MapArea& area, const Result& covered) {
  ENFILADE_ASSIGN_OR_RETURN(std::vector<std::string> names, postgres::ReadRows(covered, [&](Row& row) {
                              return NameOf(area.site, LinkPointId(std::string(row.Text())));
                            }));
  if (names.empty()) return absl::OkStatus();
  const bool more = names.size() > kNamedLinkPoints;
  if (more) names.resize(kNamedLinkPoints);
  return FailedPrecondition("{} is a keep-out area over {}{}: robots could not pass; set force if they should not",
                            NameOfArea(area), fmt::join(names, ", "), more ? " and others" : "");
}

// What an earlier request of that id has created.
absl::StatusOr<std::optional<MapArea>> FindRequested(postgres::Pool& pool, const CallContext& context,
                                                     const MapArea& area, const RequestId& request_id) {
  if (request_id.empty()) return std::optional<MapArea>();
  ENFILADE_ASSIGN_OR_RETURN(const auto earlier,
                            ExecuteAlone(pool, context, kFindMapAreaRequest,
                                         Params(area.site, request_id.value, postgres::DigestOrNull(request_id))));
  if (earlier.rows() == 0) return std::optional<MapArea>();
  ENFILADE_ASSIGN_OR_RETURN(MapAreaRow row, postgres::ReadRequested(earlier, ReadMapAreaRow, NameOfArea(area)));
  ENFILADE_ASSIGN_OR_RETURN(MapArea found, DecodeMapArea(std::move(row)));
  return std::optional<MapArea>(std::move(found));
}

// Locks the map, and checks that it may have one more area.
absl::Status CheckNewArea(Transaction& transaction, const MapArea& area, const std::string& outline, bool force) {
  transaction.Queue(kLockMapOfArea, Params(area.site, area.map));
  transaction.Queue(kCountAreas, Params(area.site, area.map));
  if (MayCloseLinkPoints(area, force)) {
    transaction.Queue(kFindCoveredLinkPoints, Params(area.site, area.map, Bytes{outline}));
  }
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<Result> results, transaction.Flush());
  const std::size_t checks = MayCloseLinkPoints(area, force) ? 3 : 2;
  const Result* const own = &results[results.size() - checks];
  const std::string map = NameOf(area.site, area.map);
  if (own[0].rows() == 0) return NotFound("{} does not exist", map);
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t count, postgres::ReadOne(
                                                          own[1], [](Row& row) { return row.Int64(); }, map));
  if (count >= kMaxAreasOfMap) {
    return ResourceExhausted("{} has {} areas, the most that are allowed: delete some first", map, count);
  }
  return checks == 3 ? ExplainCovered(area, own[2]) : absl::OkStatus();
}

}  // namespace

absl::StatusOr<MapArea> MapAreaStore::Create(const CallContext& context, const MapArea& area,
                                             const RequestId& request_id, bool force) const {
  const areas::MapArea& content = area.area;
  ENFILADE_RETURN_IF_ERROR(areas::Validate(content));
  ENFILADE_ASSIGN_OR_RETURN(std::optional<MapArea> earlier, FindRequested(pool_, context, area, request_id));
  if (earlier) return *std::move(earlier);
  const std::string outline = postgres::EncodePolygon(content.outline);
  const std::vector<std::string_view> robot_types(content.robot_types.begin(), content.robot_types.end());
  absl::Status refused;
  {
    ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
    ENFILADE_RETURN_IF_ERROR(CheckNewArea(transaction, area, outline, force));
    const auto inserted =
        transaction.Execute(kInsertMapArea, Params(area.site, area.map, area.id, content.display_name,
                                                   static_cast<std::int16_t>(content.kind), Bytes{outline}, robot_types,
                                                   content.speed_limit_mps, TimestampOrNull(content.valid_from),
                                                   TimestampOrNull(content.valid_until), postgres::NewEtag(),
                                                   postgres::IdOrNull(request_id), postgres::DigestOrNull(request_id)));
    if (inserted.ok()) {
      if (content.kind == areas::AreaKind::kIgnoreHits)
        postgres::QueueLayersVersion(transaction, {area.site, area.map});
      ENFILADE_RETURN_IF_ERROR(WithContext(transaction.Commit(), NameOfArea(area)));
      return ReadMapArea(*inserted, NameOfArea(area));
    }
    refused = inserted.status();
  }
  if (!absl::IsAlreadyExists(refused)) return WithContext(refused, NameOfArea(area));
  // The same request may have come twice at once.
  ENFILADE_ASSIGN_OR_RETURN(earlier, FindRequested(pool_, context, area, request_id));
  if (earlier) return *std::move(earlier);
  return AlreadyExists("{} exists already", NameOfArea(area));
}

absl::StatusOr<MapArea> MapAreaStore::Get(const CallContext& context, const SiteId& site, const MapId& map,
                                          const MapAreaId& id) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result, ExecuteAlone(pool_, context, kSelectMapArea, Params(site, map, id)));
  return ReadMapArea(result, NameOf(site, map, id));
}

absl::StatusOr<std::vector<MapArea>> MapAreaStore::List(const CallContext& context, const SiteId& site,
                                                        const MapId& map, const PageRequest& page) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result,
                            ExecuteAlone(pool_, context, kListMapAreas,
                                         Params(site, map, page.after, static_cast<std::int64_t>(page.limit))));
  if (result.rows() == 0) {
    ENFILADE_ASSIGN_OR_RETURN(const auto found, ExecuteAlone(pool_, context, kMapOfAreasExists, Params(site, map)));
    if (found.rows() == 0) return NotFound("{} does not exist", NameOf(site, map));
  }
  return ReadMapAreas(result);
}

absl::StatusOr<std::vector<MapArea>> MapAreaStore::ListOf(const CallContext& context, const SiteId& site,
                                                          const MapId& map, areas::AreaKind kind) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result, ExecuteAlone(pool_, context, kListMapAreasOfKind,
                                                            Params(site, map, static_cast<std::int16_t>(kind))));
  return ReadMapAreas(result);
}

absl::StatusOr<MapArea> MapAreaStore::Update(const CallContext& context, const MapArea& area, bool force) const {
  const areas::MapArea& content = area.area;
  ENFILADE_RETURN_IF_ERROR(areas::Validate(content));
  const std::string outline = postgres::EncodePolygon(content.outline);
  const std::vector<std::string_view> robot_types(content.robot_types.begin(), content.robot_types.end());
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  if (MayCloseLinkPoints(area, force)) {
    ENFILADE_ASSIGN_OR_RETURN(const Result covered,
                              transaction.Execute(kFindCoveredLinkPoints, Params(area.site, area.map, Bytes{outline})));
    ENFILADE_RETURN_IF_ERROR(ExplainCovered(area, covered));
  }
  const auto updated =
      transaction.Execute(kUpdateMapArea, Params(area.site, area.map, area.id, area.etag, content.display_name,
                                                 static_cast<std::int16_t>(content.kind), Bytes{outline}, robot_types,
                                                 content.speed_limit_mps, TimestampOrNull(content.valid_from),
                                                 TimestampOrNull(content.valid_until), postgres::NewEtag()));
  if (!updated.ok()) return WithContext(updated.status(), NameOfArea(area));
  if (updated->rows() == 0) {
    ENFILADE_ASSIGN_OR_RETURN(const auto stored,
                              transaction.Execute(kMapAreaExists, Params(area.site, area.map, area.id)));
    if (stored.rows() == 0) return NotFound("{} does not exist", NameOfArea(area));
    return postgres::StaleEtag(NameOfArea(area));
  }
  postgres::QueueLayersVersion(transaction,
                               {area.site, area.map});  // it may have been one, or be one now, that hides hits
  ENFILADE_RETURN_IF_ERROR(WithContext(transaction.Commit(), NameOfArea(area)));
  return ReadMapArea(*updated, NameOfArea(area));
}

absl::Status MapAreaStore::Delete(const CallContext& context, const SiteId& site, const MapId& map, const MapAreaId& id,
                                  std::int64_t etag) const {
  const std::string name = NameOf(site, map, id);
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  const auto deleted = transaction.Execute(kDeleteMapArea, Params(site, map, id, etag));
  if (!deleted.ok()) return WithContext(deleted.status(), name);
  if (deleted->affected() > 0) {
    postgres::QueueLayersVersion(transaction, {site, map});
    return WithContext(transaction.Commit(), name);
  }
  ENFILADE_ASSIGN_OR_RETURN(const auto stored, transaction.Execute(kMapAreaExists, Params(site, map, id)));
  if (stored.rows() == 0) return NotFound("{} does not exist", name);
  return postgres::StaleEtag(name);
}

}  // namespace enfilade::storage
