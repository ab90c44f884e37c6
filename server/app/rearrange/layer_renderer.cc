// SPDX-License-Identifier: Apache-2.0
#include "server/app/rearrange/layer_renderer.h"

#include <optional>
#include <utility>

#include "core/base/environment.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/grid/tiled_raster.h"
#include "core/slam/mapper/render_session.h"
#include "server/app/mapping/layer_overlay.h"
#include "server/app/mapping/raster_revision.h"

namespace enfilade::server {
namespace {

// That of the sessions' layers, if the map has any: mapping works with it.
const slam::SlamOptions& ProfileOf(const slam::SlamProfiles& profiles, const std::string& name,
                                   Environment environment) {
  if (const slam::SlamOptions* own = profiles.Find(name)) return *own;
  return *profiles.Find(environment == Environment::kOutdoor ? slam::SlamProfiles::kOutdoor
                                                             : slam::SlamProfiles::kIndoor);
}

}  // namespace

LayerRenderer::LayerRenderer(const storage::CallContext& context, const Rearranger::Stores& stores,
                             const slam::SlamProfiles& profiles, const SiteId& site,
                             const rearrange::Rearrangement& rearrangement)
    : context_(context), stores_(stores), profiles_(profiles), site_(site), rearrangement_(rearrangement) {
  for (const auto& move : rearrangement.moves) moved_[move.session] = {move.to, move.T_to_from, true};
  for (const auto& redirect : rearrangement.redirects) redirected_[redirect.from] = {redirect.to, redirect.T_to_from};
  for (const auto& map : rearrangement.new_maps) new_maps_.insert(map.id);
}

absl::StatusOr<std::vector<storage::RearrangedRaster>> LayerRenderer::Render() {
  std::set<MapId> changed;
  for (const auto& [map, way] : redirected_) {
    ENFILADE_RETURN_IF_ERROR(Read(map).status());
    changed.insert(way.to);
  }
  for (const auto& [id, way] : moved_) {
    ENFILADE_ASSIGN_OR_RETURN(const storage::Session session, stores_.sessions.Get(context_, site_, id));
    if (!session.map) return FailedPrecondition("session {} has no map", id.value());
    ENFILADE_RETURN_IF_ERROR(Read(*session.map).status());
    changed.insert(way.to);
    if (!redirected_.contains(*session.map)) changed.insert(*session.map);
  }
  std::vector<storage::RearrangedRaster> rasters;
  for (const MapId& map : changed) {
    ENFILADE_ASSIGN_OR_RETURN(storage::RearrangedRaster raster, RenderMap(map));
    rasters.push_back(std::move(raster));
  }
  return rasters;
}

absl::StatusOr<const storage::LayersBeside*> LayerRenderer::Read(const MapId& map) {
  const auto [found, is_new] = layers_.try_emplace(map);
  if (is_new && !new_maps_.contains(map)) {
    ENFILADE_ASSIGN_OR_RETURN(found->second, stores_.revisions.ReadLayersBeside(context_, site_, map, SessionId()));
  }
  return &found->second;
}

const LayerRenderer::Way* LayerRenderer::FindWay(const MapId& map, const storage::MapLayer& layer) const {
  if (layer.session) {
    if (const auto moved = moved_.find(*layer.session); moved != moved_.end()) return &moved->second;
  }
  const auto redirected = redirected_.find(map);
  return redirected == redirected_.end() ? nullptr : &redirected->second;
}

absl::StatusOr<storage::RearrangedRaster> LayerRenderer::RenderMap(const MapId& map) {
  storage::RearrangedRaster raster;
  raster.map = map;
  ENFILADE_ASSIGN_OR_RETURN(const storage::LayersBeside* own, Read(map));
  raster.layers_version = own->version;
  std::vector<storage::MapLayer> layers;
  for (const storage::MapLayer& layer : own->below) {
    if (FindWay(map, layer) == nullptr) layers.push_back(layer);
  }
  for (const auto& [from, others] : layers_) {
    if (from == map) continue;
    for (const storage::MapLayer& layer : others.below) {
      const Way* way = FindWay(from, layer);
      if (way == nullptr || way->to != map) continue;
      ENFILADE_ASSIGN_OR_RETURN(storage::StoredRaster moved, RenderLayer(layer, *way));
      layers.push_back({layer.session, moved});
      raster.entering.push_back({layer.session, std::move(moved)});
    }
  }
  if (layers.empty()) {
    if (own->below.empty()) return raster;
    return FailedPrecondition("map {} would be left without anything that was mapped", map.value());
  }
  ENFILADE_RETURN_IF_ERROR(Compose(layers, raster));
  return raster;
}

// A session that was deleted, or whose mapping failed, has a raster, but perhaps no longer all of its submaps; an
// import never has any: their raster is turned instead.
absl::StatusOr<storage::StoredRaster> LayerRenderer::RenderLayer(const storage::MapLayer& layer, const Way& way) {
  ENFILADE_ASSIGN_OR_RETURN(const slam::SlamOptions* options, OptionsOf(way.to));
  std::optional<grid::OccupancyGrid> grid;
  if (way.moves) {
    ENFILADE_ASSIGN_OR_RETURN(const storage::Session session, stores_.sessions.Get(context_, site_, *layer.session));
    ENFILADE_ASSIGN_OR_RETURN(const slam::SlamOptions* own, OptionsOf(*session.map));
    if (session.state == storage::SessionState::kMapped) {
      ENFILADE_ASSIGN_OR_RETURN(const auto stored, stores_.mappings.Load(context_, site_, session.id));
      if (stored) {
        ENFILADE_ASSIGN_OR_RETURN(
            grid, slam::RenderSession(stored->map, session.entry.T_map_robot.has_value(), way.T_to_from, *own));
      }
    }
  }
  if (!grid || grid->cells.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(grid::RasterAssembler assembler, grid::RasterAssembler::Create(layer.raster.header));
    for (const storage::TileRef& tile : layer.raster.tiles) {
      ENFILADE_ASSIGN_OR_RETURN(const std::string bytes, stores_.blobs.Get(context_, site_, tile.sha256));
      ENFILADE_RETURN_IF_ERROR(assembler.Add({tile.key.row, tile.key.column}, bytes));
    }
    grid::MapRaster turned = std::move(assembler).Finish();
    turned.geometry.T_map_grid = way.T_to_from * turned.geometry.T_map_grid;
    ENFILADE_ASSIGN_OR_RETURN(grid, OnMapLattice(turned, options->resolution));
  }
  ENFILADE_ASSIGN_OR_RETURN(const RasterRevision rendered, ToRevision(grid::FromOccupancyGrid(*std::move(grid))));
  ENFILADE_RETURN_IF_ERROR(PutTiles(context_, stores_.blobs, site_, rendered, {}));
  return storage::StoredRaster{rendered.revision.raster_header, rendered.revision.tiles};
}

absl::StatusOr<const slam::SlamOptions*> LayerRenderer::OptionsOf(const MapId& map) {
  for (const rearrange::MapSeed& seed : rearrangement_.new_maps) {
    if (seed.id == map) return &ProfileOf(profiles_, seed.slam_profile, seed.environment);
  }
  ENFILADE_ASSIGN_OR_RETURN(const storage::Map stored, stores_.maps.Get(context_, site_, map));
  return &ProfileOf(profiles_, stored.slam_profile, stored.environment);
}

absl::Status LayerRenderer::Compose(const std::vector<storage::MapLayer>& layers, storage::RearrangedRaster& raster) {
  ENFILADE_ASSIGN_OR_RETURN(const slam::SlamOptions* options, OptionsOf(raster.map));
  grid::OccupancyGrid none;
  none.geometry.resolution = options->resolution;
  LayerOverlay overlay(stores_.blobs, site_);
  ENFILADE_ASSIGN_OR_RETURN(grid::OccupancyGrid grid, overlay.Compose(context_, {0, layers, {}}, none));
  ENFILADE_ASSIGN_OR_RETURN(RasterRevision whole, ToRevision(grid::FromOccupancyGrid(std::move(grid))));
  ENFILADE_RETURN_IF_ERROR(PutTiles(context_, stores_.blobs, site_, whole, {}));
  whole.revision.source = storage::RevisionSource::kImport;
  for (const storage::MapLayer& layer : layers) {
    if (!layer.session) continue;
    whole.revision.source = storage::RevisionSource::kMapping;
    whole.revision.session = layer.session;
  }
  raster.revision = std::move(whole.revision);
  return absl::OkStatus();
}

}  // namespace enfilade::server
