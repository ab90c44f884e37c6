// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/maps/layer_rows.h"

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/driver/wkb.h"
#include "storage/postgres/maps/overlay_rows.h"
#include "storage/postgres/maps/tile_columns.h"

namespace enfilade::storage::postgres {
namespace {

constexpr Statement kSelectLayersVersion{
    "reading the version of the map's layers",
    "SELECT version FROM enfilade.map_layer_stacks WHERE site_id = $1 AND map_id = $2"};
constexpr Statement kLockLayers{
    "locking the map's layers",
    "SELECT version FROM enfilade.map_layer_stacks WHERE site_id = $1 AND map_id = $2 FOR UPDATE"};
// With the map's row locked, so that versions follow one another.
constexpr Statement kRaiseLayersVersion{
    "raising the version of the map's layers",
    "INSERT INTO enfilade.map_layer_stacks AS s (site_id, map_id, version) VALUES ($1, $2, 1)"
    " ON CONFLICT (site_id, map_id) DO UPDATE SET version = s.version + 1"};
// How much had been published of the map's edits when a session began: it contradicts none that is newer.
#define ENFILADE_EDITS_BEFORE(session)                                                       \
  "coalesce((SELECT min(d.edit_version) - 1 FROM enfilade.map_drafts d, enfilade.sessions s" \
  "   WHERE d.site_id = $1 AND d.map_id = $2 AND s.site_id = $1 AND s.session_id = " session \
  "   AND d.publish_time > s.create_time),"                                                  \
  "  (SELECT edit_version FROM enfilade.map_overlays WHERE site_id = $1 AND map_id = $2), 0)"
#define ENFILADE_LAYERS_VERSION "(SELECT version FROM enfilade.map_layer_stacks WHERE site_id = $1 AND map_id = $2)"
constexpr Statement kDeleteLayers{"deleting the map's layers",
                                  "DELETE FROM enfilade.map_layers WHERE site_id = $1 AND map_id = $2"};
constexpr Statement kInsertImport{"storing the map's layer",
                                  "INSERT INTO enfilade.map_layers (site_id, map_id, position, revision, version)"
                                  " VALUES ($1, $2, 1, $3, " ENFILADE_LAYERS_VERSION ")"};
constexpr Statement kUpsertLayer{
    "storing the session's layer",
    "INSERT INTO enfilade.map_layers (site_id, map_id, position, session_id, revision, raster_header, version,"
    " edit_version) SELECT $1, $2, coalesce(max(position), 0) + 1, $3, $4, $5, " ENFILADE_LAYERS_VERSION
    ", " ENFILADE_EDITS_BEFORE("$3")
    " FROM enfilade.map_layers WHERE site_id = $1 AND map_id = $2"
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
    "WITH l AS (INSERT INTO enfilade.map_layers (site_id, map_id, position, session_id, raster_header, version,"
    "     edit_version) SELECT $1, $2, coalesce(max(position), 0) + 1, $3, $4, " ENFILADE_LAYERS_VERSION
    ", " ENFILADE_EDITS_BEFORE("$3") " FROM enfilade.map_layers"
    "   WHERE site_id = $1 AND map_id = $2 RETURNING position)"
    " INSERT INTO enfilade.map_layer_tiles (site_id, map_id, position, tile_row, tile_column, sha256)"
    " SELECT $1, $2, l.position, u.* FROM l, unnest($5::integer[], $6::integer[], $7::bytea[]) u"};

constexpr Statement kForgetRuns{"forgetting runs of layers",
                                "DELETE FROM enfilade.map_layer_runs WHERE site_id = $1 AND map_id = $2"};
constexpr Statement kForgetRunOfSession{
    "forgetting a run of layers",
    "DELETE FROM enfilade.map_layer_runs WHERE site_id = $1 AND map_id = $2 AND (SELECT l.position"
    "   FROM enfilade.map_layers l WHERE l.site_id = $1 AND l.map_id = $2 AND l.session_id = $3)"
    " BETWEEN first_position AND last_position"};
constexpr Statement kForgetOverlappingRuns{
    "forgetting runs of layers",
    "DELETE FROM enfilade.map_layer_runs WHERE site_id = $1 AND map_id = $2 AND first_position <= $4"
    " AND last_position >= $3"};
constexpr Statement kInsertRun{
    "storing a run of layers",
    "INSERT INTO enfilade.map_layer_runs (site_id, map_id, first_position, last_position, resolution, reset_header,"
    " content_header) VALUES ($1, $2, $3, $4, $5, $6, $7)"};
constexpr Statement kInsertRunTiles{
    "storing the tiles of a run of layers",
    "INSERT INTO enfilade.map_layer_run_tiles (site_id, map_id, first_position, part, tile_row, tile_column, sha256)"
    " SELECT $1, $2, $3, $4, u.* FROM unnest($5::integer[], $6::integer[], $7::bytea[]) u"};

// Parts of a run, in their order.
constexpr std::int16_t kReset = 1;
constexpr std::int16_t kContent = 2;
// The version, the layers, and their tiles as rows of their own, in one snapshot: from the bottom to the top, each
// layer before its tiles. Layers in runs are not visited: only the gaps between runs are searched.
constexpr Statement kSelectLayers{
    "reading the map's layers",
    "WITH runs AS MATERIALIZED (SELECT r.first_position, r.last_position, r.reset_header, r.content_header"
    "   FROM enfilade.map_layer_runs r WHERE r.site_id = $1 AND r.map_id = $2 AND r.resolution = $4 AND NOT EXISTS ("
    "     SELECT FROM enfilade.map_layers o WHERE o.site_id = $1 AND o.map_id = $2 AND o.session_id = $3"
    "     AND o.position BETWEEN r.first_position AND r.last_position)),"
    " gaps AS MATERIALIZED (SELECT coalesce(lag(last_position) OVER (ORDER BY first_position), 0) AS low,"
    "     first_position AS high FROM runs"
    "   UNION ALL SELECT coalesce(max(last_position), 0), 9223372036854775807 FROM runs),"
    " single AS MATERIALIZED (SELECT l.* FROM gaps g CROSS JOIN LATERAL (SELECT position, version, session_id,"
    "     revision, raster_header FROM enfilade.map_layers WHERE site_id = $1 AND map_id = $2 AND position > g.low"
    "     AND position < g.high OFFSET 0) l)"
    " SELECT 0::bigint, 0::bigint, 0, version, NULL::text, NULL::bytea, NULL::bigint, NULL::bigint,"
    "   NULL::bytea FROM enfilade.map_layer_stacks WHERE site_id = $1 AND map_id = $2"
    " UNION ALL SELECT l.position, l.position, 0, l.version, l.session_id, coalesce(l.raster_header, r.raster_header),"
    "   NULL, NULL, NULL FROM single l LEFT JOIN enfilade.map_revisions r ON r.site_id = $1 AND r.map_id = $2"
    "   AND r.revision = l.revision"
    " UNION ALL SELECT first_position, last_position, 1, 0, NULL, reset_header, NULL, NULL, NULL FROM runs"
    "   WHERE reset_header IS NOT NULL"
    " UNION ALL SELECT first_position, last_position, 2, 0, NULL, content_header, NULL, NULL, NULL FROM runs"
    " UNION ALL SELECT l.position, l.position, 0, 0, NULL, NULL, t.tile_row, t.tile_column, t.sha256 FROM single l"
    "   JOIN enfilade.map_revision_tiles t ON t.site_id = $1 AND t.map_id = $2 AND t.revision = l.revision"
    "   WHERE l.session_id IS DISTINCT FROM $3"
    " UNION ALL SELECT l.position, l.position, 0, 0, NULL, NULL, t.tile_row, t.tile_column, t.sha256 FROM single l"
    "   JOIN enfilade.map_layer_tiles t ON t.site_id = $1 AND t.map_id = $2 AND t.position = l.position"
    "   WHERE l.session_id IS DISTINCT FROM $3"
    " UNION ALL SELECT r.first_position, r.last_position, t.part, 0, NULL, NULL, t.tile_row, t.tile_column, t.sha256"
    "   FROM runs r JOIN enfilade.map_layer_run_tiles t ON t.site_id = $1 AND t.map_id = $2"
    "   AND t.first_position = r.first_position"
    " ORDER BY 1, 3, 7 NULLS FIRST, 8"};

// One row of kSelectLayers: the version (position 0), a layer, or a tile of the layer before it.
struct LayerPart {
  std::int64_t version = 0;
  MapLayer layer;
  std::optional<TileRef> tile;
};

LayerPart ReadLayerPart(Row& row) {
  LayerPart part;
  part.layer.first = row.Int64();
  part.layer.last = row.Int64();
  row.Int32();  // of a run: which part
  part.version = part.layer.version = row.Int64();
  if (const auto session = row.OptionalText()) part.layer.session = SessionId(std::string(*session));
  if (const auto header = row.OptionalBytes()) part.layer.raster.header = *header;
  const auto tile_row = static_cast<int>(row.OptionalInt64().value_or(0));
  const auto tile_column = static_cast<int>(row.OptionalInt64().value_or(0));
  if (const auto sha256 = row.OptionalBytes()) part.tile = TileRef{{tile_row, tile_column}, std::string(*sha256)};
  return part;
}

// Of all areas of the kind (areas::AreaKind), whenever they hold: hits are mapped for good.
constexpr Statement kSelectIgnoredOutlines{
    "reading areas in which hits are ignored",
    "SELECT ST_AsBinary(outline, 'NDR') FROM enfilade.map_areas WHERE site_id = $1 AND map_id = $2 AND kind = 4"
    " ORDER BY area_id"};

absl::StatusOr<std::vector<std::vector<Eigen::Vector2d>>> ReadIgnoredOutlines(Pool& pool, const CallContext& context,
                                                                              const MapKey& key) {
  ENFILADE_ASSIGN_OR_RETURN(const Result result,
                            ExecuteAlone(pool, context, kSelectIgnoredOutlines, Params(key.site, key.map)));
  std::vector<std::vector<Eigen::Vector2d>> outlines;
  for (int i = 0; i < result.rows(); ++i) {
    Row row(result, i);
    const std::string_view bytes = row.Bytes();
    ENFILADE_RETURN_IF_ERROR(row.status());
    ENFILADE_ASSIGN_OR_RETURN(std::vector<Eigen::Vector2d> outline, DecodePolygon(bytes));
    outlines.push_back(std::move(outline));
  }
  return outlines;
}

absl::StatusOr<std::int64_t> VersionIn(const Result& result) {
  if (result.rows() == 0) return 0;  // the map never had a layer
  Row row(result, 0);
  const std::int64_t version = row.Int64();
  ENFILADE_RETURN_IF_ERROR(row.status());
  return version;
}

}  // namespace

absl::StatusOr<std::int64_t> ReadLayersVersion(Pool& pool, const CallContext& context, const MapKey& key) {
  ENFILADE_ASSIGN_OR_RETURN(const Result result,
                            ExecuteAlone(pool, context, kSelectLayersVersion, Params(key.site, key.map)));
  return VersionIn(result);
}

absl::StatusOr<LayersBeside> ReadLayers(Pool& pool, const CallContext& context, const MapKey& key,
                                        const SessionId& session, std::optional<double> resolution) {
  ENFILADE_ASSIGN_OR_RETURN(const Result result,
                            ExecuteAlone(pool, context, kSelectLayers, Params(key.site, key.map, session, resolution)));
  ENFILADE_ASSIGN_OR_RETURN(std::vector<LayerPart> parts, ReadRows(result, ReadLayerPart));
  LayersBeside beside;
  std::vector<MapLayer>* side = &beside.below;
  for (LayerPart& part : parts) {
    if (part.tile) {
      side->back().raster.tiles.push_back(*std::move(part.tile));
    } else if (part.layer.first == 0) {
      beside.version = part.version;
    } else if (part.layer.session == session) {
      side = &beside.above;  // its tiles are not read
    } else {
      side->push_back(std::move(part.layer));
    }
  }
  // Read last: if edits are published after the layers were read, their version is no longer that of the map.
  ENFILADE_ASSIGN_OR_RETURN(OverlayState state, ReadOverlayRows(pool, context, key));
  // Also edits that say nothing any more: what is made of these layers is made of those publications.
  if (state.overlay && state.overlay->edit_version >= state.overlay->first_version) {
    beside.edits = std::move(state.overlay);
  }
  ENFILADE_ASSIGN_OR_RETURN(beside.ignored, ReadIgnoredOutlines(pool, context, key));
  return beside;
}

absl::Status LockLayers(Transaction& transaction, const MapKey& key, std::int64_t version) {
  ENFILADE_ASSIGN_OR_RETURN(const Result locked, transaction.Execute(kLockLayers, Params(key.site, key.map)));
  if (locked.rows() == 0) return LayersChanged(key.site, key.map);
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t stored,
                            ReadOne(
                                locked, [](Row& row) { return row.Int64(); }, "the layers' version"));
  return stored == version ? absl::OkStatus() : LayersChanged(key.site, key.map);
}

absl::Status StoreRun(Transaction& transaction, const MapKey& key, const NewLayerRun& run) {
  ENFILADE_RETURN_IF_ERROR(LockLayers(transaction, key, run.layers_version));
  std::optional<Bytes> reset;
  if (run.reset) reset = Bytes{run.reset->header};
  transaction.Queue(kForgetOverlappingRuns, Params(key.site, key.map, run.first, run.last));
  transaction.Queue(kInsertRun,
                    Params(key.site, key.map, run.first, run.last, run.resolution, reset, Bytes{run.content.header}));
  const auto queue_tiles = [&](std::int16_t part, const StoredRaster& raster) {
    const TileColumns tiles(raster.tiles);
    transaction.Queue(kInsertRunTiles,
                      Params(key.site, key.map, run.first, part, tiles.rows, tiles.columns, tiles.digests));
  };
  if (run.reset) queue_tiles(kReset, *run.reset);
  queue_tiles(kContent, run.content);
  return absl::OkStatus();
}

absl::Status CheckLayers(Transaction& transaction, const MapKey& key, std::int64_t version) {
  ENFILADE_ASSIGN_OR_RETURN(const Result result, transaction.Execute(kSelectLayersVersion, Params(key.site, key.map)));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t stored, VersionIn(result));
  return stored == version ? absl::OkStatus() : LayersChanged(key.site, key.map);
}

void QueueLayersVersion(Transaction& transaction, const MapKey& key) {
  transaction.Queue(kRaiseLayersVersion, Params(key.site, key.map));
}

void QueueLayersChange(Transaction& transaction, const MapKey& key) {
  QueueLayersVersion(transaction, key);
  transaction.Queue(kForgetRuns, Params(key.site, key.map));
}

void QueueLayer(Transaction& transaction, const MapKey& key, const NewRevision& revision, std::int64_t number) {
  const auto& [site, map] = key;
  if (ReplacesLayers(revision.source)) {
    QueueLayersChange(transaction, key);
    transaction.Queue(kDeleteLayers, Params(site, map));
    if (revision.edits) {
      QueueTopLayer(transaction, key, std::nullopt, revision.edits->evidence);
    } else {
      transaction.Queue(kInsertImport, Params(site, map, number));
    }
    return;
  }
  if (!revision.session) return;
  std::optional<std::int64_t> whole;
  std::optional<Bytes> header;
  if (revision.layer) {
    header = Bytes{revision.layer->header};
  } else {
    whole = number;
  }
  const std::vector<TileRef> none;
  const TileColumns tiles(revision.layer ? revision.layer->tiles : none);
  transaction.Queue(kRaiseLayersVersion, Params(site, map));
  transaction.Queue(kForgetRunOfSession, Params(site, map, revision.session));
  transaction.Queue(kUpsertLayer, Params(site, map, revision.session, whole, header));
  transaction.Queue(kDeleteLayerTiles, Params(site, map, revision.session, tiles.rows, tiles.columns));
  if (tiles.rows.empty()) return;
  transaction.Queue(kUpsertLayerTiles, Params(site, map, revision.session, tiles.rows, tiles.columns, tiles.digests));
}

void QueueTopLayer(Transaction& transaction, const MapKey& key, const std::optional<SessionId>& session,
                   const StoredRaster& raster) {
  const TileColumns tiles(raster.tiles);
  transaction.Queue(kRaiseLayersVersion, Params(key.site, key.map));
  transaction.Queue(kInsertTopLayer,
                    Params(key.site, key.map, session, Bytes{raster.header}, tiles.rows, tiles.columns, tiles.digests));
}

}  // namespace enfilade::storage::postgres
