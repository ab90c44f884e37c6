// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/maps/orphaned_layers.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/status_macros.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/maps/layer_rows.h"
#include "storage/postgres/maps/tile_columns.h"

namespace enfilade::storage::postgres {
namespace {

// Each layer with each of its tiles, from the bottom. Neighbours of one kind have the same difference of their number
// among all and among those of their kind.
constexpr Statement kSelectOrphaned{
    "reading layers of deleted sessions",
    "WITH kinds AS (SELECT l.position, l.session_id, l.revision, l.raster_header,"
    "     coalesce(s.delete_time IS NOT NULL OR (l.session_id IS NULL AND l.revision IS NULL), false) AS orphaned"
    "   FROM enfilade.map_layers l LEFT JOIN enfilade.sessions s ON s.site_id = l.site_id"
    "     AND s.session_id = l.session_id WHERE l.site_id = $1 AND l.map_id = $2),"
    " numbered AS (SELECT *, row_number() OVER (ORDER BY position)"
    "     - row_number() OVER (PARTITION BY orphaned ORDER BY position) AS stretch FROM kinds),"
    " lowest AS (SELECT stretch FROM numbered WHERE orphaned GROUP BY stretch HAVING count(session_id) >= $3"
    "   ORDER BY min(position) LIMIT 1),"
    " found AS MATERIALIZED (SELECT n.* FROM numbered n JOIN lowest USING (stretch) WHERE n.orphaned"
    "   AND NOT EXISTS (SELECT FROM enfilade.rearrangement_images i WHERE i.site_id = $1 AND i.relation = 'layers'"
    "     AND i.key = $2) ORDER BY n.position LIMIT $4)"
    " SELECT f.position, (SELECT version FROM enfilade.map_layer_stacks WHERE site_id = $1 AND map_id = $2),"
    "   f.session_id, coalesce(f.raster_header, r.raster_header), t.tile_row::bigint, t.tile_column::bigint, t.sha256"
    " FROM found f"
    " LEFT JOIN enfilade.map_revisions r ON r.site_id = $1 AND r.map_id = $2 AND r.revision = f.revision"
    " LEFT JOIN LATERAL (SELECT tile_row, tile_column, sha256 FROM enfilade.map_layer_tiles"
    "     WHERE site_id = $1 AND map_id = $2 AND position = f.position"
    "   UNION ALL SELECT tile_row, tile_column, sha256 FROM enfilade.map_revision_tiles"
    "     WHERE site_id = $1 AND map_id = $2 AND revision = f.revision) t ON true"
    " ORDER BY 1, 5, 6"};

// Before the layers' lock, in which order whoever stores a revision takes both.
constexpr Statement kLockMergedMap{"locking the map",
                                   "SELECT FROM enfilade.maps WHERE site_id = $1 AND map_id = $2 FOR NO KEY UPDATE"};
constexpr Statement kRaiseVersion{
    "raising the version of the map's layers",
    "UPDATE enfilade.map_layer_stacks SET version = version + 1 WHERE site_id = $1 AND map_id = $2"};
// A run of all the merged layers, and of others, is what it was.
constexpr Statement kForgetRunsOfSome{
    "forgetting runs of layers",
    "DELETE FROM enfilade.map_layer_runs WHERE site_id = $1 AND map_id = $2 AND first_position <= $4"
    " AND last_position >= $3 AND NOT (first_position <= $3 AND last_position >= $4)"};
constexpr Statement kDeleteMerged{
    "deleting the layers that were merged",
    "DELETE FROM enfilade.map_layers WHERE site_id = $1 AND map_id = $2 AND position BETWEEN $3 AND $4"};
constexpr Statement kInsertMerged{
    "storing what layers were merged into",
    "WITH l AS (INSERT INTO enfilade.map_layers (site_id, map_id, position, raster_header, version)"
    "   SELECT $1, $2, $3, $4, version FROM enfilade.map_layer_stacks WHERE site_id = $1 AND map_id = $2)"
    " INSERT INTO enfilade.map_layer_tiles (site_id, map_id, position, tile_row, tile_column, sha256)"
    " SELECT $1, $2, $3, u.* FROM unnest($5::integer[], $6::integer[], $7::bytea[]) u"};

struct LayerAndTile {
  std::int64_t version = 0;
  MapLayer layer;
  std::optional<TileRef> tile;
};

LayerAndTile ReadLayerAndTile(Row& row) {
  LayerAndTile both;
  both.layer.first = both.layer.last = row.Int64();
  both.version = row.Int64();
  if (const auto session = row.OptionalText()) both.layer.session = SessionId(std::string(*session));
  both.layer.raster.header = row.Bytes();
  const auto tile_row = static_cast<int>(row.OptionalInt64().value_or(0));
  const auto tile_column = static_cast<int>(row.OptionalInt64().value_or(0));
  if (const auto sha256 = row.OptionalBytes()) both.tile = TileRef{{tile_row, tile_column}, std::string(*sha256)};
  return both;
}

}  // namespace

absl::StatusOr<OrphanedLayers> ReadOrphanedLayers(Pool& pool, const CallContext& context, const MapKey& key, int least,
                                                  int limit) {
  ENFILADE_ASSIGN_OR_RETURN(
      const Result result,
      ExecuteAlone(pool, context, kSelectOrphaned,
                   Params(key.site, key.map, static_cast<std::int64_t>(least), static_cast<std::int64_t>(limit))));
  ENFILADE_ASSIGN_OR_RETURN(std::vector<LayerAndTile> rows, ReadRows(result, ReadLayerAndTile));
  OrphanedLayers orphaned;
  for (LayerAndTile& row : rows) {
    orphaned.version = row.version;
    if (orphaned.layers.empty() || orphaned.layers.back().first != row.layer.first) {
      orphaned.layers.push_back(std::move(row.layer));
    }
    if (row.tile) orphaned.layers.back().raster.tiles.push_back(*std::move(row.tile));
  }
  return orphaned;
}

absl::Status StoreMergedLayers(Transaction& transaction, const MapKey& key, const NewLayerRun& merged) {
  ENFILADE_RETURN_IF_ERROR(transaction.Execute(kLockMergedMap, Params(key.site, key.map)).status());
  ENFILADE_RETURN_IF_ERROR(LockLayers(transaction, key, merged.layers_version));
  transaction.Queue(kRaiseVersion, Params(key.site, key.map));
  transaction.Queue(kForgetRunsOfSome, Params(key.site, key.map, merged.first, merged.last));
  transaction.Queue(kDeleteMerged, Params(key.site, key.map, merged.first, merged.last));
  const auto queue_layer = [&](std::int64_t position, const StoredRaster& raster) {
    const TileColumns tiles(raster.tiles);
    transaction.Queue(kInsertMerged, Params(key.site, key.map, position, Bytes{raster.header}, tiles.rows,
                                            tiles.columns, tiles.digests));
  };
  if (merged.reset) queue_layer(merged.first, *merged.reset);
  queue_layer(merged.last, merged.content);
  return absl::OkStatus();
}

}  // namespace enfilade::storage::postgres
