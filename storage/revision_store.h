// SPDX-License-Identifier: Apache-2.0
#pragma once

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
#include "core/grid/occupancy_grid.h"
#include "storage/blob_store.h"
#include "storage/call_context.h"

namespace enfilade::storage {
namespace postgres {
class Pool;
}

enum class RevisionSource : std::int16_t { kMapping = 1, kImport = 2 };

// Rows first, so that tiles come in the order of the raster.
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

// A raster in the pieces in which it is stored.
struct StoredRaster {
  std::string header;  // opaque to storage, at most 1 MiB: whatever else is needed to read the tiles
  std::vector<TileRef> tiles;
};

// A raster of a map that is to become a revision.
struct NewRevision {
  RevisionSource source = RevisionSource::kMapping;
  std::optional<SessionId> session;  // that it was made from
  grid::GridGeometry geometry;
  std::string raster_header;   // opaque to storage, at most 1 MiB: whatever else is needed to read the tiles
  std::string content_sha256;  // 32 raw bytes, of the whole content as the caller defines it
  std::vector<TileRef> tiles;  // the whole raster; each blob is stored already or goes along with the call
  // With a session: its own layer, where the revision is more than that, and LayersBeside::version of the others that
  // were laid together with it (unset: not checked).
  std::optional<StoredRaster> layer;
  std::optional<std::int64_t> layers_version;
};

// A map's revision is made of layers, one over the other: at the bottom what was imported, then what each session has
// seen, in the order in which the sessions came. An import is the whole map: it takes the place of all layers.
struct MapLayer {
  std::optional<SessionId> session;  // unset: imported
  StoredRaster raster;
};

// The layers of a map without one session's, from the bottom to the top.
struct LayersBeside {
  std::int64_t version = 0;     // greater with every change of any layer, the session's, too
  std::vector<MapLayer> below;  // where the session has no layer yet: all
  std::vector<MapLayer> above;
};

// Of an error: the map's layers are others than those that the revision was laid together from. Read them again.
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
};

// Thread-safe; errors common to all stores: see SiteStore.
class RevisionStore {
 public:
  explicit RevisionStore(postgres::Pool& pool) : pool_(pool) {}

  // Makes the map's next revision, current from then on. Large rasters put their blobs beforehand, in portions.
  // FAILED_PRECONDITION naming a blob that is missing; INVALID_ARGUMENT where a tile is given twice; NOT_FOUND where
  // the map is missing. A retry makes no second revision: where the map's current revision has the same source,
  // session, header and content, that one comes back. Its session's layer is stored with it; an import becomes the only
  // layer. ABORTED, with AreLayersChanged, where the layers are no longer those of `layers_version`.
  absl::StatusOr<MapRevision> Add(const CallContext& context, const SiteId& site, const MapId& map,
                                  const NewRevision& revision, absl::Span<const BlobView> blobs) const;
  // The current revision for number 0. NOT_FOUND.
  absl::StatusOr<MapRevision> Get(const CallContext& context, const SiteId& site, const MapId& map,
                                  std::int64_t number) const;
  // The newest first; those below `before` (0: all). NOT_FOUND where the map is.
  absl::StatusOr<std::vector<MapRevision>> List(const CallContext& context, const SiteId& site, const MapId& map,
                                                std::int64_t before, int limit) const;
  // For laying a session's raster between the others'. No layers where the map has none or is missing.
  absl::StatusOr<LayersBeside> ReadLayersBeside(const CallContext& context, const SiteId& site, const MapId& map,
                                                const SessionId& session) const;
  // The manifest in the order of TileKey; `number` as MapRevision has it. NOT_FOUND.
  absl::StatusOr<std::vector<TileRef>> ListTiles(const CallContext& context, const SiteId& site, const MapId& map,
                                                 std::int64_t number) const;
  // The next tiles behind `after` (unset: from the first) in the order of TileKey, of about `max_bytes` together, at
  // least one; empty at the end or where there is no such revision. No connection is held between calls.
  absl::StatusOr<std::vector<Tile>> ReadTiles(const CallContext& context, const SiteId& site, const MapId& map,
                                              std::int64_t number, std::optional<TileKey> after,
                                              std::int64_t max_bytes) const;

 private:
  postgres::Pool& pool_;
};

}  // namespace enfilade::storage
