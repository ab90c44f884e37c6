// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "core/base/ids.h"
#include "core/base/time.h"
#include "core/edit/history.h"
#include "core/edit/map_edit.h"
#include "core/grid/occupancy_grid.h"
#include "storage/call_context.h"
#include "storage/maps/blob_store.h"

namespace enfilade::storage {
// The numbers are in the database and in the API.
enum class RevisionSource : std::int16_t { kMapping = 1, kImport = 2, kEdit = 3, kRestored = 4 };

// Whether a revision is the whole map, so that it becomes the map's only layer.
constexpr bool ReplacesLayers(RevisionSource source) {
  return source == RevisionSource::kImport || source == RevisionSource::kRestored;
}

// Ordered by row, then column, as the raster is.
struct TileKey {
  int row = 0;
  int column = 0;

  friend auto operator<=>(const TileKey&, const TileKey&) = default;
};

struct TileRef {
  TileKey key;
  std::string sha256;  // of the tile's blob, 32 raw bytes
};

struct Tile {
  TileKey key;
  std::string sha256;
  std::string data;
};

// A raster as it is stored: a header and tiles.
struct StoredRaster {
  std::string header;  // opaque to storage, at most 1 MiB: whatever else is needed to read the tiles
  std::vector<TileRef> tiles;
};

// What published edits say of a map's cells (core/edit).
struct StoredOverlay {
  std::int64_t edit_version = 0;   // of the newest publication
  std::int64_t first_version = 1;  // of the oldest one that counts: an import has replaced the map before it
  edit::Lattice lattice;
  std::vector<TileRef> tiles;  // edit::Pack
};

// The edits that lie over a revision.
struct RevisionEdits {
  StoredOverlay overlay;
  StoredRaster evidence;  // the revision without them
};

// A raster of a map that becomes its next revision.
struct NewRevision {
  RevisionSource source = RevisionSource::kMapping;
  std::optional<SessionId> session;  // that it was made from
  grid::GridGeometry geometry;
  std::string raster_header;   // opaque to storage, at most 1 MiB: whatever else is needed to read the tiles
  std::string content_sha256;  // 32 raw bytes, of the whole content as the caller defines it
  std::vector<TileRef> tiles;  // of the whole raster; each blob is already stored or part of the call
  // With a session: the session's own layer if the revision contains other layers, too, and LayersBeside::version of
  // those layers (unset: not checked).
  std::optional<StoredRaster> layer;
  std::optional<std::int64_t> layers_version;
  // Unset: none lie over it; an import puts an end to those that did.
  std::optional<RevisionEdits> edits = std::nullopt;
};

// A map's revision consists of layers, overlaid from the bottom: what was imported, then what each session has seen, in
// the order of the sessions' first revisions. An import and a restored revision are the whole map: they replace all
// layers (ReplacesLayers).
struct MapLayer {
  std::optional<SessionId> session;  // unset: imported, merged, or half of a run
  StoredRaster raster;
  // Places in the order of layers. A run is that of all layers from the first to the last.
  std::int64_t first = 0;
  std::int64_t last = 0;
  std::int64_t version = 0;  // LayersBeside::version when it last changed

  bool is_run() const { return first != last; }
};

// The layers of a map except one session's, from the bottom to the top.
struct LayersBeside {
  std::int64_t version = 0;     // increases with every change of any layer, including the session's
  std::vector<MapLayer> below;  // all if the session has no layer yet
  std::vector<MapLayer> above;
  std::optional<StoredOverlay> edits = std::nullopt;  // that lie over all; unset: none
  // Outlines of areas in which hits are not mapped (areas::AreaKind::kIgnoreHits), m, in the map's frame.
  std::vector<std::vector<Eigen::Vector2d>> ignored = {};
};

// Layers that lie on one another and have not changed for a while, as two rasters that are overlaid in their place
// (grid::LayerRun). The layers themselves stay: a run is forgotten when one of them changes or goes.
struct NewLayerRun {
  std::int64_t first = 0;  // MapLayer::first of its lowest, and MapLayer::last of its highest
  std::int64_t last = 0;
  double resolution = 0.0;  // m; of the cells to which the layers were resampled
  std::int64_t layers_version = 0;
  std::optional<StoredRaster> reset;  // unset: unknown everywhere
  StoredRaster content;
};

// Layers next to one another, from the bottom, that no session changes any more.
struct OrphanedLayers {
  std::int64_t version = 0;  // LayersBeside::version
  std::vector<MapLayer> layers;
};

// ABORTED, with AreLayersChanged.
absl::Status LayersChanged(const SiteId& site, const MapId& map);
// Whether the error says that the map's layers have changed since the revision was made from them. Read them again.
bool AreLayersChanged(const absl::Status& status);

// Immutable.
struct MapRevision {
  SiteId site;
  MapId map;
  std::int64_t number = 0;  // 1, 2, 3, ... per map
  RevisionSource source = RevisionSource::kMapping;
  std::optional<SessionId> session;
  grid::GridGeometry geometry;
  std::string raster_header;
  std::string content_sha256;
  std::int64_t tile_count = 0;
  std::int64_t tile_bytes = 0;  // of all tiles, as stored
  TimeNs create_time = 0;
  std::int64_t edit_version = 0;         // the newest publication of edits that lie over it; 0: none
  std::string tag = {};                  // a name for people; empty: none
  std::vector<MapAliasId> aliases = {};  // that lead to it (MapAliasStore)
};

// The rasters of maps. Thread-safe; errors common to all stores: see SiteStore.
class RevisionStore {
 public:
  virtual ~RevisionStore() = default;

  // Makes the map's next revision and its current one. Of a large raster, put the blobs beforehand, in portions.
  // FAILED_PRECONDITION naming a blob that is missing; INVALID_ARGUMENT if a tile is given twice; NOT_FOUND if the map
  // does not exist. A retry makes no second revision: if the map's current revision has the same source, session,
  // header, content and edit_version, it is returned. Stores its session's layer, too; an import or restored revision
  // becomes the only layer. ABORTED, with AreLayersChanged, if the layers are no longer those of `layers_version`.
  virtual absl::StatusOr<MapRevision> Add(const CallContext& context, const SiteId& site, const MapId& map,
                                          const NewRevision& revision, absl::Span<const BlobView> blobs) const = 0;
  // The current revision for number 0. NOT_FOUND.
  virtual absl::StatusOr<MapRevision> Get(const CallContext& context, const SiteId& site, const MapId& map,
                                          std::int64_t number) const = 0;
  // Those below `before` (0: all), newest first. NOT_FOUND if the map does not exist.
  virtual absl::StatusOr<std::vector<MapRevision>> List(const CallContext& context, const SiteId& site,
                                                        const MapId& map, std::int64_t before, int limit) const = 0;
  // Sets a revision's tag, at most 64 characters; empty: none. A revision with a tag outlives its retention. NOT_FOUND.
  virtual absl::StatusOr<MapRevision> Tag(const CallContext& context, const SiteId& site, const MapId& map,
                                          std::int64_t number, const std::string& tag) const = 0;
  // For rendering a session's raster together with those of the others. No layers if the map has none or does not
  // exist.
  virtual absl::StatusOr<LayersBeside> ReadLayersBeside(const CallContext& context, const SiteId& site,
                                                        const MapId& map, const SessionId& session) const = 0;
  // The same with the runs for cells of `resolution` m in place of their layers, each as one or two layers of version
  // 0: `content` above `reset`. A run with the session's own layer in it does not count. Reads nothing of the layers
  // that are in runs.
  virtual absl::StatusOr<LayersBeside> ReadRunsBeside(const CallContext& context, const SiteId& site, const MapId& map,
                                                      const SessionId& session, double resolution) const = 0;
  // Puts a run in the place of those that it overlaps. Its blobs must be stored. Neither the layers nor their version
  // change. ABORTED, with AreLayersChanged, if the layers are no longer those of `layers_version`. FAILED_PRECONDITION
  // naming a blob that is missing.
  virtual absl::Status AddRun(const CallContext& context, const SiteId& site, const MapId& map,
                              const NewLayerRun& run) const = 0;
  // The lowest layers next to one another whose sessions are deleted, `least` of them or more, and layers that
  // MergeLayers made beside them; at most `limit`. Imports are not among them. None while a rearrangement of the map's
  // layers can be undone: that restores them as they were.
  virtual absl::StatusOr<OrphanedLayers> ReadOrphanedLayers(const CallContext& context, const SiteId& site,
                                                            const MapId& map, int least, int limit) const = 0;
  // Puts the rasters of `merged` in the place of the layers from its first to its last, for good. Raises the layers'
  // version. Errors as AddRun.
  virtual absl::Status MergeLayers(const CallContext& context, const SiteId& site, const MapId& map,
                                   const NewLayerRun& merged) const = 0;
  // The next tiles of `revision` after `after` (unset: from the first) in the order of TileKey: at least one, about
  // `max_bytes` in total. Empty at the end, or if there is no such revision. Holds no connection between calls.
  virtual absl::StatusOr<std::vector<Tile>> ReadTiles(const CallContext& context, const MapRevision& revision,
                                                      std::optional<TileKey> after, std::int64_t max_bytes) const = 0;

  // Edits. A store that has no drafts has none of either.
  // The map's newest revision without the edits that lie over it; unset: it has none.
  virtual absl::StatusOr<std::optional<StoredRaster>> ReadEvidence(const CallContext& /*context*/,
                                                                   const SiteId& /*site*/, const MapId& /*map*/) const {
    return std::nullopt;
  }
  // The publications of the map with an edit_version of more than `after` and at most `up_to`, in their order.
  virtual absl::StatusOr<std::vector<edit::Publication>> ReadPublications(const CallContext& /*context*/,
                                                                          const SiteId& /*site*/, const MapId& /*map*/,
                                                                          std::int64_t /*after*/,
                                                                          std::int64_t /*up_to*/) const {
    return std::vector<edit::Publication>();
  }
};

}  // namespace enfilade::storage
