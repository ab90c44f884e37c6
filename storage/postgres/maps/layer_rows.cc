// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/maps/layer_rows.h"

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "storage/postgres/driver/rows.h"

namespace enfilade::storage::postgres {
namespace {

constexpr Statement kSelectLayersVersion{
    "reading the version of the map's layers",
    "SELECT coalesce(max(version), 0) FROM enfilade.map_layers WHERE site_id = $1 AND map_id = $2"};
constexpr Statement kDeleteLayers{"deleting the map's layers",
                                  "DELETE FROM enfilade.map_layers WHERE site_id = $1 AND map_id = $2"};
constexpr Statement kInsertImport{"storing the map's layer",
                                  "INSERT INTO enfilade.map_layers (site_id, map_id, position, revision)"
                                  " VALUES ($1, $2, 1, $3)"};
constexpr Statement kUpsertLayer{
    "storing the session's layer",
    "INSERT INTO enfilade.map_layers (site_id, map_id, position, session_id, revision, raster_header)"
    " SELECT $1, $2, coalesce(max(position), 0) + 1, $3, $4, $5 FROM enfilade.map_layers"
    " WHERE site_id = $1 AND map_id = $2"
    " ON CONFLICT (site_id, map_id, session_id) WHERE session_id IS NOT NULL DO UPDATE SET"
    " revision = excluded.revision, raster_header = excluded.raster_header, version = excluded.version"};
// Writes only what has changed.
constexpr Statement kDeleteLayerTiles{
    "deleting the layer's tiles",
    "DELETE FROM enfilade.map_layer_tiles t USING enfilade.map_layers l"
    " WHERE (l.site_id, l.map_id, l.session_id) = ($1, $2, $3)"
    " AND (t.site_id, t.map_id, t.position) = (l.site_id, l.map_id, l.position)"
    " AND NOT EXISTS (SELECT FROM unnest($4::integer[], $5::integer[]) u (tile_row, tile_column)"
    "   WHERE (u.tile_row, u.tile_column) = (t.tile_row, t.tile_column))"};
constexpr Statement kUpsertLayerTiles{
    "storing the layer's tiles",
    "INSERT INTO enfilade.map_layer_tiles AS t (site_id, map_id, position, tile_row, tile_column, sha256)"
    " SELECT l.site_id, l.map_id, l.position, u.* FROM enfilade.map_layers l,"
    " unnest($4::integer[], $5::integer[], $6::bytea[]) u"
    " WHERE (l.site_id, l.map_id, l.session_id) = ($1, $2, $3)"
    " ON CONFLICT (site_id, map_id, position, tile_row, tile_column) DO UPDATE SET sha256 = excluded.sha256"
    " WHERE t.sha256 <> excluded.sha256"};

// One statement: the new layer's number is known within it only.
constexpr Statement kInsertTopLayer{
    "storing a layer",
    "WITH l AS (INSERT INTO enfilade.map_layers (site_id, map_id, position, session_id, raster_header)"
    "   SELECT $1, $2, coalesce(max(position), 0) + 1, $3, $4 FROM enfilade.map_layers"
    "   WHERE site_id = $1 AND map_id = $2 RETURNING position)"
    " INSERT INTO enfilade.map_layer_tiles (site_id, map_id, position, tile_row, tile_column, sha256)"
    " SELECT $1, $2, l.position, u.* FROM l, unnest($5::integer[], $6::integer[], $7::bytea[]) u"};

constexpr Statement kSelectLayers{
    "reading the map's layers",
    "SELECT l.position, l.version, l.session_id, coalesce(l.raster_header, r.raster_header)"
    " FROM enfilade.map_layers l LEFT JOIN enfilade.map_revisions r"
    " ON (r.site_id, r.map_id, r.revision) = (l.site_id, l.map_id, l.revision)"
    " WHERE l.site_id = $1 AND l.map_id = $2 ORDER BY l.position"};
constexpr Statement kSelectLayerTiles{
    "reading the tiles of the map's layers",
    "SELECT l.position, t.tile_row, t.tile_column, t.sha256 FROM enfilade.map_layers l"
    " JOIN enfilade.map_revision_tiles t ON (t.site_id, t.map_id, t.revision) = (l.site_id, l.map_id, l.revision)"
    " WHERE l.site_id = $1 AND l.map_id = $2 AND l.session_id IS DISTINCT FROM $3"
    " UNION ALL SELECT l.position, t.tile_row, t.tile_column, t.sha256 FROM enfilade.map_layers l"
    " JOIN enfilade.map_layer_tiles t ON (t.site_id, t.map_id, t.position) = (l.site_id, l.map_id, l.position)"
    " WHERE l.site_id = $1 AND l.map_id = $2 AND l.session_id IS DISTINCT FROM $3 ORDER BY 1, 2, 3"};

struct LayerRow {
  std::int64_t position = 0;
  std::int64_t version = 0;
  MapLayer layer;
};

LayerRow ReadLayer(Row& row) {
  LayerRow result;
  result.position = row.Int64();
  result.version = row.Int64();
  if (const auto session = row.OptionalText()) result.layer.session = SessionId(std::string(*session));
  result.layer.raster.header = row.Bytes();
  return result;
}

struct TileRow {
  std::int64_t position = 0;
  TileRef tile;
};

TileRow ReadTile(Row& row) {
  TileRow result;
  result.position = row.Int64();
  const std::int32_t tile_row = row.Int32();
  const std::int32_t tile_column = row.Int32();
  result.tile = {{tile_row, tile_column}, std::string(row.Bytes())};
  return result;
}

}  // namespace

absl::StatusOr<LayersBeside> ReadLayers(Pool& pool, const CallContext& context, const MapKey& key,
                                        const SessionId& session) {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool, context));
  transaction.Queue(kSelectLayers, Params(key.site, key.map));
  transaction.Queue(kSelectLayerTiles, Params(key.site, key.map, session));
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.FlushAndCommit());
  ENFILADE_ASSIGN_OR_RETURN(std::vector<LayerRow> layers, ReadRows(results[0], ReadLayer));
  ENFILADE_ASSIGN_OR_RETURN(std::vector<TileRow> tiles, ReadRows(results[1], ReadTile));
  LayersBeside beside;
  bool above = false;
  auto tile = tiles.begin();
  for (LayerRow& row : layers) {
    beside.version = std::max(beside.version, row.version);
    // Skips tiles of a layer that changed between the two statements: the version is stale then, too.
    while (tile != tiles.end() && tile->position < row.position) ++tile;
    for (; tile != tiles.end() && tile->position == row.position; ++tile) {
      row.layer.raster.tiles.push_back(std::move(tile->tile));
    }
    if (row.layer.session == session) {
      above = true;
    } else {
      (above ? beside.above : beside.below).push_back(std::move(row.layer));
    }
  }
  return beside;
}

absl::Status CheckLayers(Transaction& transaction, const MapKey& key, const NewRevision& revision) {
  if (!revision.layers_version) return absl::OkStatus();
  ENFILADE_ASSIGN_OR_RETURN(const Result result, transaction.Execute(kSelectLayersVersion, Params(key.site, key.map)));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t version,
                            ReadOne(
                                result, [](Row& row) { return row.Int64(); }, "the layers' version"));
  return version == *revision.layers_version ? absl::OkStatus() : LayersChanged(key.site, key.map);
}

void QueueLayer(Transaction& transaction, const MapKey& key, const NewRevision& revision, std::int64_t number) {
  const auto& [site, map] = key;
  if (!revision.session) {
    transaction.Queue(kDeleteLayers, Params(site, map));
    transaction.Queue(kInsertImport, Params(site, map, number));
    return;
  }
  std::optional<std::int64_t> whole;
  std::optional<Bytes> header;
  std::vector<std::int32_t> rows, columns;
  std::vector<Bytes> digests;
  if (revision.layer) {
    header = Bytes{revision.layer->header};
    for (const TileRef& tile : revision.layer->tiles) {
      rows.push_back(tile.key.row);
      columns.push_back(tile.key.column);
      digests.push_back(Bytes{tile.sha256});
    }
  } else {
    whole = number;
  }
  transaction.Queue(kUpsertLayer, Params(site, map, revision.session, whole, header));
  transaction.Queue(kDeleteLayerTiles, Params(site, map, revision.session, rows, columns));
  if (!rows.empty()) transaction.Queue(kUpsertLayerTiles, Params(site, map, revision.session, rows, columns, digests));
}

void QueueTopLayer(Transaction& transaction, const MapKey& key, const std::optional<SessionId>& session,
                   const StoredRaster& raster) {
  std::vector<std::int32_t> rows, columns;
  std::vector<Bytes> digests;
  for (const TileRef& tile : raster.tiles) {
    rows.push_back(tile.key.row);
    columns.push_back(tile.key.column);
    digests.push_back(Bytes{tile.sha256});
  }
  transaction.Queue(kInsertTopLayer, Params(key.site, key.map, session, Bytes{raster.header}, rows, columns, digests));
}

}  // namespace enfilade::storage::postgres
