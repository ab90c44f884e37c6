// SPDX-License-Identifier: Apache-2.0
#include "storage/maps/pyramid_store.h"

#include <utility>

#include "core/base/resource_name.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/maps/blob_store.h"

namespace enfilade::storage {
namespace {

using postgres::Bytes;
using postgres::ExecuteAlone;
using postgres::Params;
using postgres::Result;
using postgres::Row;
using postgres::Statement;

#define ENFILADE_THUMBNAIL_COLUMNS \
  "p.thumbnail_zoom, p.thumbnail_column, p.thumbnail_row, p.thumbnail_width, p.thumbnail_cells"
constexpr Statement kSelectPyramid{"reading the pyramid",
                                   "SELECT p.display_only, p.lattice_column, p.lattice_row, " ENFILADE_THUMBNAIL_COLUMNS
                                   " FROM enfilade.raster_pyramids p"
                                   " WHERE p.site_id = $1 AND p.map_id = $2 AND p.revision = $3"};
constexpr Statement kSelectPyramidTiles{"reading the pyramid's tiles",
                                        "SELECT zoom, tile_row, tile_column, sha256 FROM enfilade.raster_pyramid_tiles"
                                        " WHERE site_id = $1 AND map_id = $2 AND revision = $3 ORDER BY zoom"};
constexpr Statement kSelectPyramidBefore{"looking for an earlier pyramid",
                                         "SELECT coalesce(max(revision), 0) FROM enfilade.raster_pyramids"
                                         " WHERE site_id = $1 AND map_id = $2 AND revision < $3"};
constexpr Statement kListRevisionTiles{"listing the revision's tiles",
                                       "SELECT tile_row, tile_column, sha256 FROM enfilade.map_revision_tiles"
                                       " WHERE site_id = $1 AND map_id = $2 AND revision = $3"};
constexpr Statement kInsertPyramid{
    "storing the pyramid",
    "INSERT INTO enfilade.raster_pyramids (site_id, map_id, revision, display_only, lattice_column, lattice_row,"
    " thumbnail_zoom, thumbnail_column, thumbnail_row, thumbnail_width, thumbnail_cells)"
    " VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11) ON CONFLICT DO NOTHING RETURNING true"};
constexpr Statement kInsertPyramidTiles{
    "storing the pyramid's tiles",
    "INSERT INTO enfilade.raster_pyramid_tiles (site_id, map_id, revision, zoom, tile_row, tile_column, sha256)"
    " SELECT $1, $2, $3, u.zoom, u.tile_row, u.tile_column, u.sha256"
    " FROM unnest($4::smallint[], $5::integer[], $6::integer[], $7::bytea[])"
    " AS u (zoom, tile_row, tile_column, sha256) ORDER BY u.sha256"};
// Other blobs of the site, such as pictures of places, are nobody's tiles.
constexpr Statement kSelectTileBlobs{
    "reading tiles of pyramids",
    "SELECT b.sha256, b.data FROM enfilade.blobs b WHERE b.site_id = $1 AND b.sha256 = ANY ($2)"
    " AND EXISTS (SELECT FROM enfilade.raster_pyramid_tiles t WHERE t.site_id = $1 AND t.sha256 = b.sha256)"};
constexpr Statement kSiteIsThere{"looking for the site",
                                 "SELECT true FROM enfilade.sites WHERE site_id = $1 AND delete_time IS NULL"};
constexpr Statement kListThumbnails{
    "listing pictures of maps",
    "SELECT m.map_id, r.revision, r.resolution, r.origin_x, r.origin_y, r.origin_yaw, r.width, r.height,"
    " p.site_id IS NOT NULL, coalesce(p.lattice_column, 0), coalesce(p.lattice_row, 0),"
    " coalesce(p.thumbnail_zoom, 0::smallint), coalesce(p.thumbnail_column, 0), coalesce(p.thumbnail_row, 0),"
    " coalesce(p.thumbnail_width, 1), coalesce(p.thumbnail_cells, '')"
    " FROM enfilade.maps m JOIN enfilade.map_revisions r"
    "   ON r.site_id = m.site_id AND r.map_id = m.map_id AND r.revision = m.current_revision"
    " LEFT JOIN enfilade.raster_pyramids p"
    "   ON p.site_id = r.site_id AND p.map_id = r.map_id AND p.revision = r.revision"
    " WHERE m.site_id = $1 AND r.site_id = $1 AND m.map_id > $2 AND ($3::integer IS NULL OR m.level = $3)"
    " ORDER BY m.map_id LIMIT $4"};

grid::Thumbnail ReadThumbnail(Row& row) {
  grid::Thumbnail thumbnail;
  thumbnail.zoom = row.Int16();
  thumbnail.lower_left.column = row.Int32();
  thumbnail.lower_left.row = row.Int32();
  thumbnail.width = std::max(1, row.Int32());
  const std::string_view cells = row.Bytes();
  thumbnail.classes.assign(cells.begin(), cells.end());
  thumbnail.height = static_cast<int>(cells.size()) / thumbnail.width;
  return thumbnail;
}

MapThumbnail ReadMapThumbnail(Row& row) {
  MapThumbnail map;
  map.map = MapId(std::string(row.Text()));
  map.revision = row.Int64();
  map.geometry.resolution = row.Double();
  map.geometry.T_map_grid = {row.Double(), row.Double(), row.Double()};
  map.geometry.width = row.Int32();
  map.geometry.height = row.Int32();
  const bool is_made = row.Bool();
  map.lattice_min.column = row.Int32();
  map.lattice_min.row = row.Int32();
  grid::Thumbnail thumbnail = ReadThumbnail(row);
  if (is_made) map.thumbnail = std::move(thumbnail);
  return map;
}

absl::StatusOr<std::vector<grid::RasterPyramid::Level>> ReadLevels(const Result& result) {
  std::vector<grid::RasterPyramid::Level> levels(1);
  for (int i = 0; i < result.rows(); ++i) {
    Row row(result, i);
    const auto zoom = static_cast<std::size_t>(row.Int16());
    const int tile_row = row.Int32();
    const int tile_column = row.Int32();
    std::string sha256(row.Bytes());
    ENFILADE_RETURN_IF_ERROR(row.status());
    if (levels.size() <= zoom) levels.resize(zoom + 1);
    levels[zoom].emplace(grid::TileIndex{tile_row, tile_column}, std::move(sha256));
  }
  return levels;
}

void QueueTiles(postgres::Transaction& transaction, const SiteId& site, const MapId& map, std::int64_t revision,
                const StoredPyramid& pyramid) {
  std::vector<std::int16_t> zooms;
  std::vector<std::int32_t> rows, columns;
  std::vector<Bytes> digests;
  for (std::size_t zoom = 0; zoom < pyramid.levels.size(); ++zoom) {
    for (const auto& [index, sha256] : pyramid.levels[zoom]) {
      zooms.push_back(static_cast<std::int16_t>(zoom));
      rows.push_back(index.row);
      columns.push_back(index.column);
      digests.push_back(Bytes{sha256});
    }
  }
  transaction.Queue(kInsertPyramidTiles, Params(site, map, revision, zooms, rows, columns, digests));
}

absl::Status ExplainPyramidError(const absl::Status& status, const SiteId& site, const MapId& map,
                                 std::int64_t revision) {
  const std::string name = fmt::format("{}/revisions/{}", NameOf(site, map), revision);
  const std::string constraint = postgres::ConstraintOf(status);
  if (constraint == "raster_pyramid_tiles_site_id_sha256_fkey") {
    return FailedPrecondition("a tile's blob of {} is not stored", name);
  }
  if (constraint == "raster_pyramids_site_id_map_id_revision_fkey") return NotFound("{} does not exist", name);
  return WithContext(status, name);
}

}  // namespace

absl::StatusOr<std::optional<StoredPyramid>> PyramidStore::Find(const CallContext& context, const SiteId& site,
                                                                const MapId& map, std::int64_t revision) const {
  ENFILADE_ASSIGN_OR_RETURN(auto transaction, postgres::Transaction::Begin(pool_, context));
  // The tiles are committed with the pyramid: those of one that is found are all there.
  transaction.Queue(kSelectPyramid, Params(site, map, revision));
  transaction.Queue(kSelectPyramidTiles, Params(site, map, revision));
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.FlushAndCommit());
  if (results[0].rows() == 0) return std::nullopt;
  StoredPyramid pyramid;
  Row row(results[0], 0);
  pyramid.display_only = row.Bool();
  pyramid.lattice_min.column = row.Int32();
  pyramid.lattice_min.row = row.Int32();
  pyramid.thumbnail = ReadThumbnail(row);
  ENFILADE_RETURN_IF_ERROR(row.status());
  ENFILADE_ASSIGN_OR_RETURN(pyramid.levels, ReadLevels(results[1]));
  return pyramid;
}

absl::StatusOr<std::int64_t> PyramidStore::FindBefore(const CallContext& context, const SiteId& site, const MapId& map,
                                                      std::int64_t revision) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result,
                            ExecuteAlone(pool_, context, kSelectPyramidBefore, Params(site, map, revision)));
  return postgres::ReadOne(
      result, [](Row& row) { return row.Int64(); }, NameOf(site, map));
}

absl::StatusOr<grid::RasterPyramid::Level> PyramidStore::ListTiles(const CallContext& context, const SiteId& site,
                                                                   const MapId& map, std::int64_t revision) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result,
                            ExecuteAlone(pool_, context, kListRevisionTiles, Params(site, map, revision)));
  grid::RasterPyramid::Level level;
  for (int i = 0; i < result.rows(); ++i) {
    Row row(result, i);
    const int tile_row = row.Int32();
    const int tile_column = row.Int32();
    level.emplace(grid::TileIndex{tile_row, tile_column}, std::string(row.Bytes()));
    ENFILADE_RETURN_IF_ERROR(row.status());
  }
  return level;
}

absl::Status PyramidStore::Add(const CallContext& context, const SiteId& site, const MapId& map, std::int64_t revision,
                               const StoredPyramid& pyramid, absl::Span<const BlobView> blobs) const {
  ENFILADE_RETURN_IF_ERROR(ValidateBlobs(blobs));
  const grid::Thumbnail& thumbnail = pyramid.thumbnail;
  const std::string_view cells(reinterpret_cast<const char*>(thumbnail.classes.data()), thumbnail.classes.size());
  ENFILADE_ASSIGN_OR_RETURN(auto transaction, postgres::Transaction::Begin(pool_, context));
  const auto inserted = transaction.Execute(
      kInsertPyramid, Params(site, map, revision, pyramid.display_only, std::int32_t{pyramid.lattice_min.column},
                             std::int32_t{pyramid.lattice_min.row}, static_cast<std::int16_t>(thumbnail.zoom),
                             std::int32_t{thumbnail.lower_left.column}, std::int32_t{thumbnail.lower_left.row},
                             std::int32_t{thumbnail.width}, Bytes{cells}));
  if (!inserted.ok()) return ExplainPyramidError(inserted.status(), site, map, revision);
  if (inserted->rows() == 0) return absl::OkStatus();
  postgres::QueueBlobs(transaction, site, blobs);
  QueueTiles(transaction, site, map, revision, pyramid);
  const absl::Status committed = transaction.Commit();
  return committed.ok() ? committed : ExplainPyramidError(committed, site, map, revision);
}

absl::StatusOr<std::map<std::string, std::string>> PyramidStore::ReadTiles(
    const CallContext& context, const SiteId& site, const std::vector<std::string>& sha256) const {
  std::vector<Bytes> digests;
  for (const std::string& digest : sha256) digests.push_back(Bytes{digest});
  ENFILADE_ASSIGN_OR_RETURN(const auto result, ExecuteAlone(pool_, context, kSelectTileBlobs, Params(site, digests)));
  std::map<std::string, std::string> tiles;
  for (int i = 0; i < result.rows(); ++i) {
    Row row(result, i);
    std::string digest(row.Bytes());
    tiles.emplace(std::move(digest), std::string(row.Bytes()));
    ENFILADE_RETURN_IF_ERROR(row.status());
  }
  return tiles;
}

absl::StatusOr<std::vector<MapThumbnail>> PyramidStore::ListThumbnails(const CallContext& context, const SiteId& site,
                                                                       std::optional<int> level, const MapId& after,
                                                                       int limit) const {
  std::optional<std::int32_t> on_level;
  if (level) on_level = *level;
  ENFILADE_ASSIGN_OR_RETURN(auto transaction, postgres::Transaction::Begin(pool_, context));
  transaction.Queue(kSiteIsThere, Params(site));
  transaction.Queue(kListThumbnails, Params(site, after, on_level, std::int64_t{limit}));
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.FlushAndCommit());
  if (results[0].rows() == 0) return NotFound("{} does not exist", NameOf(site));
  return postgres::ReadRows(results[1], ReadMapThumbnail);
}

}  // namespace enfilade::storage
