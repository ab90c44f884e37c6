// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/maps/revision_store.h"

#include <limits>

#include "core/base/resource_name.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/maps/layer_rows.h"
#include "storage/postgres/maps/map_edit_rows.h"
#include "storage/postgres/maps/orphaned_layers.h"
#include "storage/postgres/maps/overlay_rows.h"
#include "storage/postgres/maps/revision_rows.h"

namespace enfilade::storage::postgres {
namespace {

#define ENFILADE_REVISION_COLUMNS                                                                             \
  "site_id, map_id, revision, source, session_id, resolution, origin_x, origin_y, origin_yaw, width, height," \
  " raster_header, content_sha256, tile_count, tile_bytes, create_time, tag, edit_version,"                   \
  " (SELECT coalesce(array_agg(a.alias_id::text ORDER BY a.alias_id), '{}') FROM enfilade.map_aliases a"      \
  "   WHERE a.site_id = $1 AND a.map_id = map_revisions.map_id AND a.revision = map_revisions.revision)"

constexpr Statement kSelectRevision{"reading the revision",
                                    "SELECT " ENFILADE_REVISION_COLUMNS
                                    " FROM enfilade.map_revisions WHERE site_id = $1 AND map_id = $2"
                                    " AND revision = $3"};
constexpr Statement kSelectNewestRevision{"reading the map's revision",
                                          "SELECT " ENFILADE_REVISION_COLUMNS
                                          " FROM enfilade.map_revisions WHERE site_id = $1 AND (map_id, revision) ="
                                          " (SELECT m.map_id, m.current_revision FROM enfilade.resolve_map($1, $2) r"
                                          "   JOIN enfilade.maps m ON m.site_id = $1 AND m.map_id = r.map_id)"};
constexpr Statement kSelectCurrentRevision{"looking for the map",
                                           "SELECT current_revision FROM enfilade.maps WHERE site_id = $1 AND map_id ="
                                           " (SELECT r.map_id FROM enfilade.resolve_map($1, $2) r)"};
constexpr Statement kListRevisions{"listing revisions",
                                   "SELECT " ENFILADE_REVISION_COLUMNS
                                   " FROM enfilade.map_revisions WHERE site_id = $1 AND map_id = $2 AND revision < $3"
                                   " ORDER BY revision DESC LIMIT $4"};
constexpr Statement kTagRevision{"tagging the revision",
                                 "UPDATE enfilade.map_revisions SET tag = $4 WHERE site_id = $1 AND map_id = $2"
                                 " AND revision = $3 RETURNING " ENFILADE_REVISION_COLUMNS};
// Reads as many tiles as fit by their mean size, and returns those that do fit.
constexpr Statement kReadTiles{
    "reading tiles",
    "SELECT t.tile_row, t.tile_column, t.sha256, b.data FROM ("
    "  SELECT tile_row, tile_column, sha256,"
    "    sum(size) OVER (ORDER BY tile_row, tile_column) - size AS bytes_before FROM ("
    "    SELECT t.tile_row, t.tile_column, t.sha256, b.size FROM enfilade.map_revision_tiles t"
    "    JOIN enfilade.blobs b ON b.site_id = t.site_id AND b.sha256 = t.sha256"
    "    WHERE t.site_id = $1 AND t.map_id = $2 AND t.revision = $3 AND (t.tile_row, t.tile_column) > ($4, $5)"
    "    ORDER BY t.tile_row, t.tile_column LIMIT (SELECT 1 + $6 * tile_count / (1 + tile_bytes)"
    "      FROM enfilade.map_revisions WHERE site_id = $1 AND map_id = $2 AND revision = $3)) s) t"
    " JOIN enfilade.blobs b ON b.site_id = $1 AND b.sha256 = t.sha256"
    " WHERE t.bytes_before < $6 ORDER BY t.tile_row, t.tile_column"};

MapRevision ReadRevision(Row& row) {
  MapRevision revision;
  revision.site = SiteId(std::string(row.Text()));
  revision.map = MapId(std::string(row.Text()));
  revision.number = row.Int64();
  revision.source = static_cast<RevisionSource>(row.Int16());
  if (const auto session = row.OptionalText()) revision.session = SessionId(std::string(*session));
  revision.geometry.resolution = row.Double();
  revision.geometry.T_map_grid.x = row.Double();
  revision.geometry.T_map_grid.y = row.Double();
  revision.geometry.T_map_grid.yaw = row.Double();
  revision.geometry.width = row.Int32();
  revision.geometry.height = row.Int32();
  revision.raster_header = row.Bytes();
  revision.content_sha256 = row.Bytes();
  revision.tile_count = row.Int64();
  revision.tile_bytes = row.Int64();
  revision.create_time = row.Time();
  revision.tag = row.Text();
  revision.edit_version = row.Int64();
  for (std::string& alias : row.OptionalTexts()) revision.aliases.emplace_back(std::move(alias));
  return revision;
}

std::string NameOfRevision(const SiteId& site, const MapId& map, std::int64_t number) {
  if (number == 0) return fmt::format("a revision of {}", NameOf(site, map));
  return fmt::format("{}/revisions/{}", NameOf(site, map), number);
}

}  // namespace

absl::StatusOr<MapRevision> RevisionStore::Add(const CallContext& context, const SiteId& site, const MapId& map,
                                               const NewRevision& revision, absl::Span<const BlobView> blobs) const {
  ENFILADE_RETURN_IF_ERROR(ValidateBlobs(blobs));
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  const auto number = AddRevision(transaction, {site, map}, revision, blobs, MapState::kReady);
  if (!number.ok()) return ExplainRevisionError(number.status(), site, map);
  transaction.Queue(kSelectRevision, Params(site, map, *number));
  const auto results = transaction.FlushAndCommit();
  if (!results.ok()) return ExplainRevisionError(results.status(), site, map);
  return ReadOne(results->back(), ReadRevision, NameOfRevision(site, map, *number));
}

absl::StatusOr<MapRevision> RevisionStore::Get(const CallContext& context, const SiteId& site, const MapId& map,
                                               std::int64_t number) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result,
                            number == 0 ? ExecuteAlone(pool_, context, kSelectNewestRevision, Params(site, map))
                                        : ExecuteAlone(pool_, context, kSelectRevision, Params(site, map, number)));
  return ReadOne(result, ReadRevision, NameOfRevision(site, map, number));
}

absl::StatusOr<std::vector<MapRevision>> RevisionStore::List(const CallContext& context, const SiteId& site,
                                                             const MapId& map, std::int64_t before, int limit) const {
  const std::int64_t below = before > 0 ? before : std::numeric_limits<std::int64_t>::max();
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  transaction.Queue(kSelectCurrentRevision, Params(site, map));
  transaction.Queue(kListRevisions, Params(site, map, below, static_cast<std::int64_t>(limit)));
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.FlushAndCommit());
  if (results[0].rows() == 0) return NotFound("{} does not exist", NameOf(site, map));
  return ReadRows(results[1], ReadRevision);
}

absl::StatusOr<MapRevision> RevisionStore::Tag(const CallContext& context, const SiteId& site, const MapId& map,
                                               std::int64_t number, const std::string& tag) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  transaction.Queue(kTagRevision, Params(site, map, number, tag));
  QueueRevisionReview(transaction, {site, map});
  const auto results = transaction.FlushAndCommit();
  if (SqlStateOf(results.status()) == "23503") return NotFound("{} does not exist", NameOfRevision(site, map, number));
  ENFILADE_RETURN_IF_ERROR(WithContext(results.status(), NameOfRevision(site, map, number)));
  return ReadOne(results->front(), ReadRevision, NameOfRevision(site, map, number));
}

absl::StatusOr<LayersBeside> RevisionStore::ReadLayersBeside(const CallContext& context, const SiteId& site,
                                                             const MapId& map, const SessionId& session) const {
  return ReadLayers(pool_, context, {site, map}, session, std::nullopt);
}

absl::StatusOr<LayersBeside> RevisionStore::ReadRunsBeside(const CallContext& context, const SiteId& site,
                                                           const MapId& map, const SessionId& session,
                                                           double resolution) const {
  return ReadLayers(pool_, context, {site, map}, session, resolution);
}

absl::Status RevisionStore::AddRun(const CallContext& context, const SiteId& site, const MapId& map,
                                   const NewLayerRun& run) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  absl::Status status = StoreRun(transaction, {site, map}, run);
  if (status.ok()) status = transaction.FlushAndCommit().status();
  return status.ok() ? status : ExplainRevisionError(status, site, map);
}

absl::StatusOr<OrphanedLayers> RevisionStore::ReadOrphanedLayers(const CallContext& context, const SiteId& site,
                                                                 const MapId& map, int least, int limit) const {
  return postgres::ReadOrphanedLayers(pool_, context, {site, map}, least, limit);
}

absl::Status RevisionStore::MergeLayers(const CallContext& context, const SiteId& site, const MapId& map,
                                        const NewLayerRun& merged) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  absl::Status status = StoreMergedLayers(transaction, {site, map}, merged);
  if (status.ok()) status = transaction.FlushAndCommit().status();
  return status.ok() ? status : ExplainRevisionError(status, site, map);
}

absl::StatusOr<std::vector<Tile>> RevisionStore::ReadTiles(const CallContext& context, const MapRevision& revision,
                                                           std::optional<TileKey> after, std::int64_t max_bytes) const {
  constexpr int kFirst = std::numeric_limits<std::int32_t>::min();
  const TileKey last = after.value_or(TileKey{kFirst, kFirst});
  ENFILADE_ASSIGN_OR_RETURN(const auto result,
                            ExecuteAlone(pool_, context, kReadTiles,
                                         Params(revision.site, revision.map, revision.number, std::int32_t{last.row},
                                                std::int32_t{last.column}, max_bytes)));
  return ReadRows(result, [](Row& row) {
    const std::int32_t tile_row = row.Int32();
    const std::int32_t tile_column = row.Int32();
    Tile tile{{tile_row, tile_column}, std::string(row.Bytes()), {}};
    tile.data = row.Bytes();
    return tile;
  });
}

absl::StatusOr<std::optional<StoredRaster>> RevisionStore::ReadEvidence(const CallContext& context, const SiteId& site,
                                                                        const MapId& map) const {
  ENFILADE_ASSIGN_OR_RETURN(OverlayState state, ReadOverlayRows(pool_, context, {site, map}));
  return std::move(state.evidence);
}

absl::StatusOr<std::vector<edit::Publication>> RevisionStore::ReadPublications(const CallContext& context,
                                                                               const SiteId& site, const MapId& map,
                                                                               std::int64_t after,
                                                                               std::int64_t up_to) const {
  return ReadPublicationRows(pool_, context, {site, map}, after, up_to);
}

}  // namespace enfilade::storage::postgres
