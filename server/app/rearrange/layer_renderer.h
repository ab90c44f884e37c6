// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "absl/status/statusor.h"
#include "core/grid/occupancy_grid.h"
#include "core/rearrange/rearrangement.h"
#include "core/slam/slam_profiles.h"
#include "server/app/mapping/layer_overlay.h"
#include "server/app/rearrange/rearranger.h"
#include "storage/call_context.h"
#include "storage/graph/rearrangement_store.h"

namespace enfilade::server {

// Renders what a rearrangement makes of the maps' rasters, beforehand: the layers of the sessions that move, from their
// submaps in the new frame, and the revisions that overlay them. Nothing is stored but the tiles' blobs, which nothing
// refers to yet.
class LayerRenderer {
 public:
  LayerRenderer(const storage::CallContext& context, const Rearranger::Stores& stores,
                const slam::SlamProfiles& profiles, const SiteId& site, const rearrange::Rearrangement& rearrangement);

  // Of each map whose layers change and that stays. FAILED_PRECONDITION if a map would keep no layer, or its layers
  // are too far apart for one raster.
  absl::StatusOr<std::vector<storage::RearrangedRaster>> Render();

 private:
  // The layers of a map that is there before.
  absl::StatusOr<const storage::LayersBeside*> Read(const MapId& map);
  // Where a layer goes.
  struct Way {
    MapId to = {};
    Pose2 T_to_from = {};
    bool is_drawn = false;  // from its session's submaps; otherwise its raster is turned
  };
  // What a layer becomes: of a session that is cut, the keyframes from record `first` to the one before `end`.
  struct Piece {
    std::optional<SessionId> session = {};
    Way way = {};
    std::int64_t first = 0;
    std::int64_t end = std::numeric_limits<std::int64_t>::max();
  };
  // Empty if the layer stays as it is.
  std::vector<Piece> PiecesOf(const MapId& map, const storage::MapLayer& layer) const;
  Way WayOf(const MapId& map, const SessionId& session) const;
  absl::StatusOr<storage::RearrangedRaster> RenderMap(const MapId& map);
  // Empty if a piece shows nothing.
  absl::StatusOr<grid::OccupancyGrid> DrawPiece(const storage::MapLayer& layer, const Piece& piece);
  // Unset if nothing was mapped.
  absl::StatusOr<std::optional<slam::SlamMap>> ReadSubmaps(const SessionId& session, const Piece& piece);
  absl::StatusOr<const slam::SlamOptions*> OptionsOf(const MapId& map);
  // `resolution`: of the raster, m.
  absl::Status Compose(const std::vector<storage::MapLayer>& layers, double resolution, LayerOverlay& overlay,
                       storage::RearrangedRaster& raster);

  const storage::CallContext& context_;
  const Rearranger::Stores& stores_;
  const slam::SlamProfiles& profiles_;
  const SiteId& site_;
  const rearrange::Rearrangement& rearrangement_;
  std::map<SessionId, Way> moved_;
  std::map<MapId, Way> redirected_;
  // By the session that is cut: the rests by their first records.
  std::map<SessionId, std::map<std::int64_t, SessionId>> cuts_;
  std::map<SessionId, slam::SlamMap> cut_maps_;  // of these sessions: each is drawn piece by piece
  std::set<MapId> new_maps_;
  std::map<MapId, storage::LayersBeside> layers_;
};

}  // namespace enfilade::server
