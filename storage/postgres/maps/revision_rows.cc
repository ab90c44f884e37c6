// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/maps/revision_rows.h"

#include "core/base/resource_name.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/maps/blob_store.h"
#include "storage/postgres/maps/layer_rows.h"
#include "storage/postgres/maps/overlay_rows.h"
#include "storage/postgres/maps/tile_columns.h"

namespace enfilade::storage::postgres {
namespace {

// NO KEY: new sessions, which refer to the map, are not blocked.
constexpr Statement kLockMapForRevision{
    "locking the map",
    "SELECT m.current_revision, coalesce(r.source = $3 AND r.session_id IS NOT DISTINCT FROM $4"
    " AND r.content_sha256 = $5 AND r.raster_header = $6 AND r.edit_version = $7, false)"
    " FROM enfilade.maps m LEFT JOIN enfilade.map_revisions r"
    " ON (r.site_id, r.map_id, r.revision) = (m.site_id, m.map_id, m.current_revision)"
    " WHERE m.site_id = $1 AND m.map_id = $2 AND m.redirect_map_id IS NULL FOR NO KEY UPDATE OF m"};
constexpr Statement kInsertRevision{
    "storing the revision",
    "INSERT INTO enfilade.map_revisions (site_id, map_id, revision, source, session_id, resolution, origin_x, origin_y,"
    " origin_yaw, width, height, raster_header, content_sha256, edit_version, tile_count, tile_bytes)"
    " SELECT $1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $15, cardinality($14::bytea[]),"
    " coalesce(sum(b.size), 0)"
    " FROM unnest($14::bytea[]) AS u (sha256) JOIN enfilade.blobs b ON b.site_id = $1 AND b.sha256 = u.sha256"};
constexpr Statement kInsertTiles{
    "storing the revision's tiles",
    "INSERT INTO enfilade.map_revision_tiles (site_id, map_id, revision, tile_row, tile_column, sha256)"
    " SELECT $1, $2, $3, u.* FROM unnest($4::integer[], $5::integer[], $6::bytea[]) u"};
constexpr Statement kSetRevisionState{"updating the map",
                                      "UPDATE enfilade.maps SET current_revision = $3, state = $4"
                                      " WHERE site_id = $1 AND map_id = $2"};
constexpr Statement kReviewMap{"having the map's revisions reviewed",
                               "INSERT INTO enfilade.revision_reviews AS r (site_id, map_id, due_time)"
                               " VALUES ($1, $2, now()) ON CONFLICT (site_id, map_id)"
                               " DO UPDATE SET due_time = excluded.due_time WHERE r.due_time > excluded.due_time"};

// Of the newest publication that lies over it; 0 if an import has put an end to all of them.
std::int64_t EditVersionOf(const NewRevision& revision) {
  if (!revision.edits || revision.edits->overlay.edit_version < revision.edits->overlay.first_version) return 0;
  return revision.edits->overlay.edit_version;
}

void QueueRevision(Transaction& transaction, const MapKey& key, const NewRevision& revision, std::int64_t number) {
  const TileColumns tiles(revision.tiles);
  const grid::GridGeometry& grid = revision.geometry;
  transaction.Queue(kInsertRevision,
                    Params(key.site, key.map, number, static_cast<std::int16_t>(revision.source), revision.session,
                           grid.resolution, grid.T_map_grid.x, grid.T_map_grid.y, grid.T_map_grid.yaw,
                           std::int32_t{grid.width}, std::int32_t{grid.height}, Bytes{revision.raster_header},
                           Bytes{revision.content_sha256}, tiles.digests, EditVersionOf(revision)));
  transaction.Queue(kInsertTiles, Params(key.site, key.map, number, tiles.rows, tiles.columns, tiles.digests));
}

}  // namespace

void QueueRevisionReview(Transaction& transaction, const MapKey& key) {
  transaction.Queue(kReviewMap, Params(key.site, key.map));
}

absl::StatusOr<std::int64_t> StoreRevision(Transaction& transaction, const MapKey& key, const NewRevision& revision,
                                           absl::Span<const BlobView> blobs, MapState state) {
  const auto& [site, map] = key;
  const auto source = static_cast<std::int16_t>(revision.source);
  ENFILADE_ASSIGN_OR_RETURN(
      const Result locked,
      transaction.Execute(kLockMapForRevision,
                          Params(site, map, source, revision.session, Bytes{revision.content_sha256},
                                 Bytes{revision.raster_header}, EditVersionOf(revision))));
  if (locked.rows() == 0) return NotFound("{} does not exist", NameOf(site, map));
  Row row(locked, 0);
  std::int64_t number = row.Int64();
  const bool stored = row.Bool();
  ENFILADE_RETURN_IF_ERROR(row.status());
  if (revision.layers_version) ENFILADE_RETURN_IF_ERROR(CheckLayers(transaction, key, *revision.layers_version));
  QueueBlobs(transaction, site, blobs);
  if (!stored) {
    ++number;
    QueueRevision(transaction, key, revision, number);
    if (number > 1) QueueRevisionReview(transaction, key);
  }
  QueueRevisionEdits(transaction, key, revision);
  transaction.Queue(kSetRevisionState, Params(site, map, number, static_cast<std::int16_t>(state)));
  return number;
}

absl::StatusOr<std::int64_t> AddRevision(Transaction& transaction, const MapKey& key, const NewRevision& revision,
                                         absl::Span<const BlobView> blobs, MapState state) {
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t number, StoreRevision(transaction, key, revision, blobs, state));
  QueueLayer(transaction, key, revision, number);
  return number;
}

absl::Status ExplainRevisionError(const absl::Status& status, const SiteId& site, const MapId& map) {
  if (AreLayersChanged(status) || absl::IsNotFound(status)) return status;  // they name the map
  const std::string constraint = ConstraintOf(status);
  if (constraint == "map_revision_tiles_site_id_sha256_fkey" || constraint == "map_layer_tiles_site_id_sha256_fkey" ||
      constraint == "map_layer_run_tiles_site_id_sha256_fkey" ||
      constraint == "map_overlay_tiles_site_id_sha256_fkey") {
    return FailedPrecondition("a tile's blob is not stored: {}", std::string(status.message()));
  }
  if (constraint == "map_revision_tiles_pkey") {
    return InvalidArgument("a tile is given twice: {}", std::string(status.message()));
  }
  return WithContext(status, NameOf(site, map));
}

}  // namespace enfilade::storage::postgres
