// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/maps/overlay_rows.h"

#include <string>
#include <utility>
#include <vector>

#include "storage/postgres/driver/rows.h"
#include "storage/postgres/maps/tile_columns.h"

namespace enfilade::storage::postgres {
namespace {

constexpr std::int16_t kInstructions = 1;
constexpr std::int16_t kEvidence = 2;

// The map's row is locked: versions follow one another.
constexpr Statement kUpsertOverlay{
    "storing the map's edits",
    "INSERT INTO enfilade.map_overlays AS o (site_id, map_id, edit_version, first_version, resolution, origin_x,"
    " origin_y, origin_yaw, evidence_header) VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9)"
    " ON CONFLICT (site_id, map_id) DO UPDATE SET edit_version = excluded.edit_version,"
    " first_version = excluded.first_version, resolution = excluded.resolution, origin_x = excluded.origin_x,"
    " origin_y = excluded.origin_y, origin_yaw = excluded.origin_yaw, evidence_header = excluded.evidence_header"};
constexpr Statement kForgetEvidence{"forgetting what is below the map's edits",
                                    "UPDATE enfilade.map_overlays SET evidence_header = NULL"
                                    " WHERE site_id = $1 AND map_id = $2"};
constexpr Statement kEndEdits{"ending the map's edits",
                              "UPDATE enfilade.map_overlays SET first_version = edit_version + 1"
                              " WHERE site_id = $1 AND map_id = $2"};
constexpr Statement kDeletePart{"deleting tiles of the map's edits",
                                "DELETE FROM enfilade.map_overlay_tiles"
                                " WHERE site_id = $1 AND map_id = $2 AND part = $3"};
// Writes only what has changed.
constexpr Statement kDeletePartTiles{
    "deleting tiles of the map's edits",
    "DELETE FROM enfilade.map_overlay_tiles t WHERE site_id = $1 AND map_id = $2 AND part = $3"
    " AND NOT EXISTS (SELECT FROM unnest($4::integer[], $5::integer[]) u (tile_row, tile_column)"
    "   WHERE (u.tile_row, u.tile_column) = (t.tile_row, t.tile_column))"};
constexpr Statement kUpsertPartTiles{
    "storing tiles of the map's edits",
    "INSERT INTO enfilade.map_overlay_tiles AS t (site_id, map_id, part, tile_row, tile_column, sha256)"
    " SELECT $1, $2, $3, u.* FROM unnest($4::integer[], $5::integer[], $6::bytea[]) u"
    " ON CONFLICT (site_id, map_id, part, tile_row, tile_column) DO UPDATE SET sha256 = excluded.sha256"
    " WHERE t.sha256 <> excluded.sha256"};
// The overlay, then its tiles, in one snapshot.
constexpr Statement kSelectOverlay{
    "reading the map's edits",
    "SELECT 0::smallint, edit_version, first_version, resolution, origin_x, origin_y, origin_yaw, evidence_header,"
    "   NULL::bigint, NULL::bigint, NULL::bytea FROM enfilade.map_overlays WHERE site_id = $1 AND map_id = $2"
    " UNION ALL SELECT part, 0, 0, 0, 0, 0, 0, NULL, tile_row, tile_column, sha256 FROM enfilade.map_overlay_tiles"
    "   WHERE site_id = $1 AND map_id = $2 ORDER BY 1, 9 NULLS FIRST, 10"};

void QueuePart(Transaction& transaction, const MapKey& key, std::int16_t part, const std::vector<TileRef>& refs) {
  const TileColumns tiles(refs);
  transaction.Queue(kDeletePartTiles, Params(key.site, key.map, part, tiles.rows, tiles.columns));
  transaction.Queue(kUpsertPartTiles, Params(key.site, key.map, part, tiles.rows, tiles.columns, tiles.digests));
}

}  // namespace

edit::Lattice ReadLattice(Row& row) {
  edit::Lattice lattice;
  lattice.resolution = row.Double();
  lattice.T_map_lattice.x = row.Double();
  lattice.T_map_lattice.y = row.Double();
  lattice.T_map_lattice.yaw = row.Double();
  return lattice;
}

void QueueRevisionEdits(Transaction& transaction, const MapKey& key, const NewRevision& revision) {
  if (!revision.edits) {
    if (ReplacesLayers(revision.source)) {
      transaction.Queue(kEndEdits, Params(key.site, key.map));
      transaction.Queue(kDeletePart, Params(key.site, key.map, kInstructions));
    }
    transaction.Queue(kForgetEvidence, Params(key.site, key.map));
    transaction.Queue(kDeletePart, Params(key.site, key.map, kEvidence));
    return;
  }
  const StoredOverlay& overlay = revision.edits->overlay;
  const Pose2& origin = overlay.lattice.T_map_lattice;
  transaction.Queue(kUpsertOverlay,
                    Params(key.site, key.map, overlay.edit_version, overlay.first_version, overlay.lattice.resolution,
                           origin.x, origin.y, origin.yaw, Bytes{revision.edits->evidence.header}));
  QueuePart(transaction, key, kInstructions, overlay.tiles);
  QueuePart(transaction, key, kEvidence, revision.edits->evidence.tiles);
}

absl::StatusOr<OverlayState> ReadOverlayRows(Pool& pool, const CallContext& context, const MapKey& key) {
  ENFILADE_ASSIGN_OR_RETURN(const Result result,
                            ExecuteAlone(pool, context, kSelectOverlay, Params(key.site, key.map)));
  OverlayState state;
  for (int i = 0; i < result.rows(); ++i) {
    Row row(result, i);
    const std::int16_t part = row.Int16();
    StoredOverlay overlay;
    overlay.edit_version = row.Int64();
    overlay.first_version = row.Int64();
    overlay.lattice = ReadLattice(row);
    const auto header = row.OptionalBytes();
    const auto tile_row = static_cast<int>(row.OptionalInt64().value_or(0));
    const auto tile_column = static_cast<int>(row.OptionalInt64().value_or(0));
    const auto sha256 = row.OptionalBytes();
    ENFILADE_RETURN_IF_ERROR(row.status());
    if (!sha256) {
      state.overlay = std::move(overlay);
      if (header) state.evidence = StoredRaster{std::string(*header), {}};
      continue;
    }
    TileRef tile{{tile_row, tile_column}, std::string(*sha256)};
    if (part == kInstructions && state.overlay) state.overlay->tiles.push_back(std::move(tile));
    if (part == kEvidence && state.evidence) state.evidence->tiles.push_back(std::move(tile));
  }
  return state;
}

}  // namespace enfilade::storage::postgres
