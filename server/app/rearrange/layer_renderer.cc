// SPDX-License-Identifier: Apache-2.0
#include "server/app/rearrange/layer_renderer.h"

#include <optional>
#include <utility>

#include "core/base/environment.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/grid/tiled_raster.h"
#include "core/slam/mapper/render_session.h"
#include "server/app/edits/edited_revision.h"
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

// The submaps with keyframes from record `first` to the one before `end`, and those without any (the existing map that
// a session continued) with the first ones.
slam::SlamMap SubmapsOf(const slam::SlamMap& map, std::int64_t first, std::int64_t end) {
  std::set<std::int64_t> used, kept;
  for (const auto& [id, node] : map.nodes) {
    used.insert(node.submap);
    if (node.sequence >= first && node.sequence < end) kept.insert(node.submap);
  }
  slam::SlamMap part;
  for (const auto& [id, submap] : map.submaps) {
    if (kept.contains(id) || (first == 0 && !used.contains(id))) part.submaps.emplace(id, submap);
  }
  return part;
}

}  // namespace

LayerRenderer::LayerRenderer(const storage::CallContext& context, const Rearranger::Stores& stores,
                             const slam::SlamProfiles& profiles, const SiteId& site,
                             const rearrange::Rearrangement& rearrangement)
    : context_(context), stores_(stores), profiles_(profiles), site_(site), rearrangement_(rearrangement) {
  for (const auto& move : rearrangement.moves) moved_[move.session] = {move.to, move.T_to_from, true};
  for (const auto& redirect : rearrangement.redirects) redirected_[redirect.from] = {redirect.to, redirect.T_to_from};
  for (const auto& cut : rearrangement.cuts) cuts_[cut.session][cut.first_sequence] = cut.rest;
  for (const auto& map : rearrangement.new_maps) new_maps_.insert(map.id);
}

absl::StatusOr<std::vector<storage::RearrangedRaster>> LayerRenderer::Render() {
  std::set<MapId> changed;
  std::set<SessionId> rests;  // are not there yet
  for (const auto& [map, way] : redirected_) {
    ENFILADE_RETURN_IF_ERROR(Read(map).status());
    changed.insert(way.to);
  }
  std::set<SessionId> sessions;
  for (const auto& [session, cuts] : cuts_) {
    sessions.insert(session);
    for (const auto& [first_sequence, rest] : cuts) rests.insert(rest);
  }
  for (const auto& [session, way] : moved_) {
    changed.insert(way.to);
    if (!rests.contains(session)) sessions.insert(session);
  }
  for (const SessionId& id : sessions) {
    ENFILADE_ASSIGN_OR_RETURN(const storage::Session session, stores_.sessions.Get(context_, site_, id));
    if (!session.map) return FailedPrecondition("session {} has no map", id.value());
    ENFILADE_RETURN_IF_ERROR(Read(*session.map).status());
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

LayerRenderer::Way LayerRenderer::WayOf(const MapId& map, const SessionId& session) const {
  if (const auto moved = moved_.find(session); moved != moved_.end()) return moved->second;
  return {map, {}, true};
}

std::vector<LayerRenderer::Piece> LayerRenderer::PiecesOf(const MapId& map, const storage::MapLayer& layer) const {
  if (layer.session) {
    if (const auto found = cuts_.find(*layer.session); found != cuts_.end()) {
      std::vector<Piece> pieces{{layer.session, WayOf(map, *layer.session)}};
      for (const auto& [first_sequence, rest] : found->second) {
        pieces.back().end = first_sequence;
        pieces.push_back({rest, WayOf(map, rest), first_sequence});
      }
      return pieces;
    }
    if (moved_.contains(*layer.session)) return {Piece{layer.session, WayOf(map, *layer.session)}};
  }
  const auto redirected = redirected_.find(map);
  if (redirected == redirected_.end()) return {};
  return {Piece{layer.session, redirected->second}};
}

absl::StatusOr<storage::RearrangedRaster> LayerRenderer::RenderMap(const MapId& map) {
  storage::RearrangedRaster raster;
  raster.map = map;
  ENFILADE_ASSIGN_OR_RETURN(const storage::LayersBeside* own, Read(map));
  raster.layers_version = own->version;
  ENFILADE_ASSIGN_OR_RETURN(const slam::SlamOptions* options, OptionsOf(map));
  LayerOverlay overlay(stores_.blobs, site_);
  std::vector<storage::MapLayer> layers;
  for (const storage::MapLayer& layer : own->below) {
    if (PiecesOf(map, layer).empty()) layers.push_back(layer);
  }
  for (const auto& [from, others] : layers_) {
    for (const storage::MapLayer& layer : others.below) {
      for (const Piece& piece : PiecesOf(from, layer)) {
        if (piece.way.to != map) continue;
        ENFILADE_ASSIGN_OR_RETURN(grid::OccupancyGrid grid, DrawPiece(layer, piece));
        if (grid.cells.empty()) continue;
        ENFILADE_ASSIGN_OR_RETURN(const RasterRevision drawn, ToRevision(grid::FromOccupancyGrid(grid)));
        ENFILADE_RETURN_IF_ERROR(PutTiles(context_, stores_.blobs, site_, drawn, {}));
        layers.push_back({piece.session, {drawn.revision.raster_header, drawn.revision.tiles}});
        if (grid.geometry.resolution == options->resolution) overlay.Keep(layers.back().raster, std::move(grid));
        raster.entering.push_back({piece.session, layers.back().raster});
      }
    }
  }
  if (layers.empty()) {
    if (own->below.empty()) return raster;
    return FailedPrecondition("map {} would be left without anything that was mapped", map.value());
  }
  ENFILADE_RETURN_IF_ERROR(Compose(layers, options->resolution, overlay, raster));
  return raster;
}

// A session that was deleted, or whose mapping failed, has a raster, but perhaps no longer all of its submaps; an
// import never has any: their raster is turned instead.
absl::StatusOr<grid::OccupancyGrid> LayerRenderer::DrawPiece(const storage::MapLayer& layer, const Piece& piece) {
  if (piece.way.is_drawn) {
    ENFILADE_ASSIGN_OR_RETURN(const storage::Session session, stores_.sessions.Get(context_, site_, *layer.session));
    ENFILADE_ASSIGN_OR_RETURN(const slam::SlamOptions* own, OptionsOf(*session.map));
    if (session.state == storage::SessionState::kMapped) {
      ENFILADE_ASSIGN_OR_RETURN(const std::optional<slam::SlamMap> part, ReadSubmaps(session.id, piece));
      if (part) return slam::RenderSession(*part, session.entry.T_map_robot.has_value(), piece.way.T_to_from, *own);
    }
  }
  ENFILADE_ASSIGN_OR_RETURN(const slam::SlamOptions* options, OptionsOf(piece.way.to));
  ENFILADE_ASSIGN_OR_RETURN(grid::RasterAssembler assembler, grid::RasterAssembler::Create(layer.raster.header));
  for (const storage::TileRef& tile : layer.raster.tiles) {
    ENFILADE_ASSIGN_OR_RETURN(const std::string bytes, stores_.blobs.Get(context_, site_, tile.sha256));
    ENFILADE_RETURN_IF_ERROR(assembler.Add({tile.key.row, tile.key.column}, bytes));
  }
  grid::MapRaster turned = std::move(assembler).Finish();
  turned.geometry.T_map_grid = piece.way.T_to_from * turned.geometry.T_map_grid;
  return OnMapLattice(turned, options->resolution);
}

absl::StatusOr<std::optional<slam::SlamMap>> LayerRenderer::ReadSubmaps(const SessionId& session, const Piece& piece) {
  auto known = cut_maps_.find(session);
  if (known == cut_maps_.end()) {
    ENFILADE_ASSIGN_OR_RETURN(auto stored, stores_.mappings.Load(context_, site_, session));
    if (!stored) return std::nullopt;
    if (!cuts_.contains(session)) return SubmapsOf(stored->map, piece.first, piece.end);
    known = cut_maps_.emplace(session, std::move(stored->map)).first;
  }
  return SubmapsOf(known->second, piece.first, piece.end);
}

absl::StatusOr<const slam::SlamOptions*> LayerRenderer::OptionsOf(const MapId& map) {
  for (const rearrange::MapSeed& seed : rearrangement_.new_maps) {
    if (seed.id == map) return &ProfileOf(profiles_, seed.slam_profile, seed.environment);
  }
  ENFILADE_ASSIGN_OR_RETURN(const storage::Map stored, stores_.maps.Get(context_, site_, map));
  return &ProfileOf(profiles_, stored.slam_profile, stored.environment);
}

absl::Status LayerRenderer::Compose(const std::vector<storage::MapLayer>& layers, double resolution,
                                    LayerOverlay& overlay, storage::RearrangedRaster& raster) {
  grid::OccupancyGrid none;
  none.geometry.resolution = resolution;
  ENFILADE_ASSIGN_OR_RETURN(const storage::LayersBeside* own, Read(raster.map));
  const storage::LayersBeside all{.version = 0, .below = layers, .above = {}, .edits = {}, .ignored = own->ignored};
  ENFILADE_ASSIGN_OR_RETURN(grid::OccupancyGrid grid, overlay.Compose(context_, all, none));
  ENFILADE_ASSIGN_OR_RETURN(RasterRevision whole,
                            StoreEdited(context_, {stores_.blobs, stores_.revisions}, {site_, raster.map}, own->edits,
                                        grid::FromOccupancyGrid(std::move(grid)), {}));
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
