// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "tests/fakes/in_memory_stores.h"
#include "tests/fakes/map_rows.h"

namespace enfilade::testing {
namespace {

absl::Status CheckTiles(const SiteRows& site, const std::vector<storage::TileRef>& tiles,
                        absl::Span<const storage::BlobView> blobs) {
  for (const storage::TileRef& tile : tiles) {
    const bool sent = std::any_of(blobs.begin(), blobs.end(),
                                  [&](const storage::BlobView& blob) { return blob.sha256 == tile.sha256; });
    if (sent || site.blobs.contains(tile.sha256)) continue;
    return FailedPrecondition("a tile's blob is not stored: {}", ToHex(tile.sha256));
  }
  return absl::OkStatus();
}

bool IsCurrent(const MapRow& row, const storage::NewRevision& revision) {
  if (row.revisions.empty()) return false;
  const storage::MapRevision& current = row.revisions.back().revision;
  return current.source == revision.source && current.session == revision.session &&
         current.content_sha256 == revision.content_sha256 && current.raster_header == revision.raster_header;
}

void SortTiles(storage::StoredRaster& raster) {
  std::sort(raster.tiles.begin(), raster.tiles.end(),
            [](const storage::TileRef& a, const storage::TileRef& b) { return a.key < b.key; });
}

std::map<storage::TileKey, std::string> TilesOf(const storage::StoredRaster& raster) {
  std::map<storage::TileKey, std::string> tiles;
  for (const storage::TileRef& tile : raster.tiles) tiles.emplace(tile.key, tile.sha256);
  return tiles;
}

void SetLayer(MapRow& row, const storage::NewRevision& revision) {
  const storage::StoredRaster whole{revision.raster_header, revision.tiles};
  if (storage::ReplacesLayers(revision.source)) {
    row.layers.clear();
    row.runs.clear();
    AddTopLayer(row, std::nullopt, whole);
    return;
  }
  if (!revision.session) return;
  const auto layer = std::find_if(row.layers.begin(), row.layers.end(), [&](const storage::MapLayer& candidate) {
    return candidate.session == revision.session;
  });
  if (layer == row.layers.end()) return AddTopLayer(row, revision.session, revision.layer.value_or(whole));
  layer->version = ++row.layers_version;
  layer->raster = revision.layer.value_or(whole);
  SortTiles(layer->raster);
  std::erase_if(row.runs,
                [&](const storage::NewLayerRun& run) { return run.first <= layer->first && run.last >= layer->last; });
}

bool IsImport(const MapRow& row, const storage::MapLayer& layer) {
  return !layer.session && std::any_of(row.revisions.begin(), row.revisions.end(), [&](const RevisionRow& revision) {
    if (!storage::ReplacesLayers(revision.revision.source)) return false;
    return revision.revision.raster_header == layer.raster.header && TilesOf(layer.raster) == revision.tiles;
  });
}

bool IsOrphaned(const SiteRows& site, const MapRow& row, const storage::MapLayer& layer) {
  if (!layer.session) return !IsImport(row, layer);
  const auto session = site.sessions.find(*layer.session);
  return session != site.sessions.end() && session->second.deleted;
}

// Whether undoing a rearrangement restores the map's layers.
bool CanBeRestored(const SiteRows& site, const MapId& map) {
  return std::any_of(site.rearrangements.begin(), site.rearrangements.end(), [&](const auto& rearrangement) {
    return rearrangement.second.images_before.contains({"layers", map.value()});
  });
}

// The run's layers, from the bottom.
std::vector<storage::MapLayer> LayersOf(const storage::NewLayerRun& run) {
  std::vector<storage::MapLayer> layers;
  if (run.reset) layers.push_back({std::nullopt, *run.reset, run.first, run.last});
  layers.push_back({std::nullopt, run.content, run.first, run.last});
  for (storage::MapLayer& layer : layers) SortTiles(layer.raster);
  return layers;
}

// The map whose layers are those that the run was made from, and whose blobs are stored.
absl::StatusOr<MapRow*> GetMapForRun(InMemoryDatabase::Access& access, const SiteId& site, const MapId& map,
                                     const storage::NewLayerRun& run) {
  const auto row = access.GetMap(site, map);
  if (!row.ok() || (*row)->layers_version != run.layers_version) return storage::LayersChanged(site, map);
  ENFILADE_RETURN_IF_ERROR(CheckTiles(*access.FindSite(site), run.content.tiles, {}));
  if (run.reset) ENFILADE_RETURN_IF_ERROR(CheckTiles(*access.FindSite(site), run.reset->tiles, {}));
  return *row;
}

}  // namespace

rearrange::MapRedirect ResolveMap(const SiteRows& site, const MapId& map) {
  rearrange::MapRedirect whole{map, map, {}};
  for (auto row = site.maps.find(map); row != site.maps.end() && row->second.redirect; row = site.maps.find(whole.to)) {
    whole.to = row->second.redirect->to;
    whole.T_to_from = row->second.redirect->T_to_from * whole.T_to_from;
  }
  return whole;
}

void AddTopLayer(MapRow& row, const std::optional<SessionId>& session, const storage::StoredRaster& raster) {
  const std::int64_t position = row.layers.empty() ? 1 : row.layers.back().last + 1;
  row.layers.push_back({session, raster, position, position, ++row.layers_version});
  SortTiles(row.layers.back().raster);
}

absl::StatusOr<std::int64_t> StoreRevision(InMemoryDatabase::Access& access, const SiteId& site, const MapId& map,
                                           const storage::NewRevision& revision,
                                           absl::Span<const storage::BlobView> blobs) {
  ENFILADE_ASSIGN_OR_RETURN(MapRow* const row, access.GetMapInUse(site, map));
  SiteRows& rows = *access.FindSite(site);
  if (revision.layers_version && *revision.layers_version != row->layers_version) {
    return storage::LayersChanged(site, map);
  }
  const grid::GridGeometry& geometry = revision.geometry;
  if (!(geometry.resolution > 0.0) || geometry.width < 0 || geometry.height < 0) {
    return InvalidArgument("the revision's geometry is invalid");
  }
  ENFILADE_RETURN_IF_ERROR(CheckTiles(rows, revision.tiles, blobs));
  if (revision.layer) ENFILADE_RETURN_IF_ERROR(CheckTiles(rows, revision.layer->tiles, blobs));
  RevisionRow added;
  for (const storage::TileRef& tile : revision.tiles) {
    if (!added.tiles.emplace(tile.key, tile.sha256).second) {
      return InvalidArgument("a tile is given twice: row {}, column {}", tile.key.row, tile.key.column);
    }
  }
  for (const storage::BlobView& blob : blobs) rows.blobs[std::string(blob.sha256)] = blob.data;
  if (!IsCurrent(*row, revision)) {
    added.revision = {site,
                      map,
                      static_cast<std::int64_t>(row->revisions.size()) + 1,
                      revision.source,
                      revision.session,
                      geometry,
                      revision.raster_header,
                      revision.content_sha256,
                      static_cast<std::int64_t>(revision.tiles.size()),
                      0,
                      access.Timestamp()};
    for (const storage::TileRef& tile : revision.tiles) {
      added.revision.tile_bytes += static_cast<std::int64_t>(rows.blobs.at(tile.sha256).size());
    }
    row->revisions.push_back(std::move(added));
  }
  row->map.current_revision = row->revisions.back().revision.number;
  return row->map.current_revision;
}

absl::StatusOr<std::int64_t> AddRevision(InMemoryDatabase::Access& access, const SiteId& site, const MapId& map,
                                         const storage::NewRevision& revision,
                                         absl::Span<const storage::BlobView> blobs) {
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t number, StoreRevision(access, site, map, revision, blobs));
  ENFILADE_ASSIGN_OR_RETURN(MapRow* const row, access.GetMap(site, map));
  SetLayer(*row, revision);
  return number;
}

absl::StatusOr<storage::MapRevision> InMemoryRevisionStore::Add(const storage::CallContext& context, const SiteId& site,
                                                                const MapId& map, const storage::NewRevision& revision,
                                                                absl::Span<const storage::BlobView> blobs) const {
  ENFILADE_RETURN_IF_ERROR(storage::ValidateBlobs(blobs));
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t number, AddRevision(access, site, map, revision, blobs));
  ENFILADE_ASSIGN_OR_RETURN(MapRow* const row, access.GetMap(site, map));
  row->map.state = storage::MapState::kReady;
  return row->revisions.at(static_cast<std::size_t>(number) - 1).revision;
}

absl::StatusOr<storage::MapRevision> InMemoryRevisionStore::Get(const storage::CallContext& context, const SiteId& site,
                                                                const MapId& map, std::int64_t number) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  const SiteRows* const rows = access.FindSite(site);
  const auto row = access.GetMap(site, rows != nullptr && number == 0 ? ResolveMap(*rows, map).to : map);
  if (row.ok()) {
    const auto& revisions = (*row)->revisions;
    const auto count = static_cast<std::int64_t>(revisions.size());
    const std::int64_t wanted = number == 0 ? count : number;
    if (wanted >= 1 && wanted <= count) return revisions[static_cast<std::size_t>(wanted) - 1].revision;
  }
  return NotFound("revision {} of {} does not exist", number, NameOf(site, map));
}

absl::StatusOr<std::vector<storage::MapRevision>> InMemoryRevisionStore::List(const storage::CallContext& context,
                                                                              const SiteId& site, const MapId& map,
                                                                              std::int64_t before, int limit) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  ENFILADE_ASSIGN_OR_RETURN(const MapRow* const row, access.GetMap(site, map));
  std::vector<storage::MapRevision> revisions;
  for (auto stored = row->revisions.rbegin(); stored != row->revisions.rend(); ++stored) {
    if (before > 0 && stored->revision.number >= before) continue;
    if (revisions.size() == static_cast<std::size_t>(limit)) break;
    revisions.push_back(stored->revision);
  }
  return revisions;
}

absl::StatusOr<storage::MapRevision> InMemoryRevisionStore::Tag(const storage::CallContext& context, const SiteId& site,
                                                                const MapId& map, std::int64_t number,
                                                                const std::string& tag) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  const auto row = access.GetMap(site, map);
  if (!row.ok() || number < 1 || number > static_cast<std::int64_t>((*row)->revisions.size())) {
    return NotFound("revision {} of {} does not exist", number, NameOf(site, map));
  }
  storage::MapRevision& revision = (*row)->revisions[static_cast<std::size_t>(number) - 1].revision;
  revision.tag = tag;
  return revision;
}

absl::StatusOr<storage::LayersBeside> InMemoryRevisionStore::ReadLayersBeside(const storage::CallContext& context,
                                                                              const SiteId& site, const MapId& map,
                                                                              const SessionId& session) const {
  return ReadRunsBeside(context, site, map, session, 0.0);
}

absl::StatusOr<storage::LayersBeside> InMemoryRevisionStore::ReadRunsBeside(const storage::CallContext& context,
                                                                            const SiteId& site, const MapId& map,
                                                                            const SessionId& session,
                                                                            double resolution) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  storage::LayersBeside beside;
  const auto row = access.GetMap(site, map);
  if (!row.ok()) return beside;
  beside.version = (*row)->layers_version;
  std::vector<storage::MapLayer> layers = (*row)->layers;
  for (const storage::NewLayerRun& run : (*row)->runs) {
    const auto is_in_run = [&](const storage::MapLayer& layer) {
      return layer.first >= run.first && layer.last <= run.last;
    };
    const bool has_own = std::any_of(layers.begin(), layers.end(), [&](const storage::MapLayer& layer) {
      return layer.session == session && is_in_run(layer);
    });
    if (run.resolution != resolution || has_own) continue;
    const auto first = std::find_if(layers.begin(), layers.end(), is_in_run);
    const auto place = layers.erase(first, std::find_if_not(first, layers.end(), is_in_run));
    const std::vector<storage::MapLayer> parts = LayersOf(run);
    layers.insert(place, parts.begin(), parts.end());
  }
  bool above = false;
  for (const storage::MapLayer& layer : layers) {
    if (layer.session == session) {
      above = true;
    } else {
      (above ? beside.above : beside.below).push_back(layer);
    }
  }
  return beside;
}

absl::Status InMemoryRevisionStore::AddRun(const storage::CallContext& context, const SiteId& site, const MapId& map,
                                           const storage::NewLayerRun& run) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  ENFILADE_ASSIGN_OR_RETURN(MapRow* const row, GetMapForRun(access, site, map, run));
  std::erase_if(row->runs,
                [&](const storage::NewLayerRun& other) { return other.first <= run.last && other.last >= run.first; });
  row->runs.push_back(run);
  return absl::OkStatus();
}

absl::StatusOr<storage::OrphanedLayers> InMemoryRevisionStore::ReadOrphanedLayers(const storage::CallContext& context,
                                                                                  const SiteId& site, const MapId& map,
                                                                                  int least, int limit) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  const auto row = access.GetMap(site, map);
  if (!row.ok()) return storage::OrphanedLayers{};
  const SiteRows& rows = *access.FindSite(site);
  if (CanBeRestored(rows, map)) return storage::OrphanedLayers{};
  const auto& layers = (*row)->layers;
  const auto orphaned = [&](const storage::MapLayer& layer) { return IsOrphaned(rows, **row, layer); };
  for (auto begin = layers.begin(); begin != layers.end();) {
    begin = std::find_if(begin, layers.end(), orphaned);
    const auto end = std::find_if_not(begin, layers.end(), orphaned);
    if (std::count_if(begin, end, [](const auto& layer) { return layer.session.has_value(); }) >= least) {
      return storage::OrphanedLayers{(*row)->layers_version,
                                     {begin, std::min(end, begin + std::min<std::ptrdiff_t>(limit, end - begin))}};
    }
    begin = end;
  }
  return storage::OrphanedLayers{};
}

absl::Status InMemoryRevisionStore::MergeLayers(const storage::CallContext& context, const SiteId& site,
                                                const MapId& map, const storage::NewLayerRun& merged) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  ENFILADE_ASSIGN_OR_RETURN(MapRow* const row, GetMapForRun(access, site, map, merged));
  const std::int64_t version = ++row->layers_version;
  std::erase_if(row->runs, [&](const storage::NewLayerRun& run) {
    const bool has_all = run.first <= merged.first && run.last >= merged.last;
    return run.first <= merged.last && run.last >= merged.first && !has_all;
  });
  const auto is_merged = [&](const storage::MapLayer& layer) {
    return layer.first >= merged.first && layer.last <= merged.last;
  };
  const auto first = std::find_if(row->layers.begin(), row->layers.end(), is_merged);
  auto place = row->layers.erase(first, std::find_if_not(first, row->layers.end(), is_merged));
  place = row->layers.insert(place, {std::nullopt, merged.content, merged.last, merged.last, version});
  SortTiles(place->raster);
  if (!merged.reset) return absl::OkStatus();
  place = row->layers.insert(place, {std::nullopt, *merged.reset, merged.first, merged.first, version});
  SortTiles(place->raster);
  return absl::OkStatus();
}

absl::StatusOr<std::vector<storage::Tile>> InMemoryRevisionStore::ReadTiles(const storage::CallContext& context,
                                                                            const storage::MapRevision& revision,
                                                                            std::optional<storage::TileKey> after,
                                                                            std::int64_t max_bytes) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  std::vector<storage::Tile> tiles;
  const auto row = access.GetMap(revision.site, revision.map);
  if (!row.ok() || revision.number < 1) return tiles;
  const auto index = static_cast<std::size_t>(revision.number) - 1;
  if (index >= (*row)->revisions.size()) return tiles;
  const SiteRows& site = *access.FindSite(revision.site);
  const auto& stored = (*row)->revisions[index].tiles;
  std::int64_t bytes = 0;
  for (auto tile = after ? stored.upper_bound(*after) : stored.begin(); tile != stored.end(); ++tile) {
    if (bytes >= max_bytes) break;
    tiles.push_back({tile->first, tile->second, site.blobs.at(tile->second)});
    bytes += static_cast<std::int64_t>(tiles.back().data.size());
  }
  return tiles;
}

}  // namespace enfilade::testing
