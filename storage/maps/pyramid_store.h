// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "core/base/ids.h"
#include "core/grid/raster_pyramid.h"
#include "storage/call_context.h"
#include "storage/maps/blob_store.h"
#include "storage/maps/revision_store.h"

namespace enfilade::storage {
namespace postgres {
class Pool;
}

// What viewers see of a revision.
struct StoredPyramid {
  bool display_only = false;    // zoom 0 is made from cells of another form
  grid::CellIndex lattice_min;  // where the raster begins on the lattice of tiles
  std::vector<grid::RasterPyramid::Level> levels;
  grid::Thumbnail thumbnail;
};

// The current revision of a map, and its picture if its pyramid is made.
struct MapThumbnail {
  MapId map;
  std::int64_t revision = 0;
  grid::GridGeometry geometry;
  grid::CellIndex lattice_min;
  std::optional<grid::Thumbnail> thumbnail;
};

// The pyramids of maps' revisions. They keep their tiles' blobs, and go with their revisions. Thread-safe; errors
// common to all stores: see SiteStore.
class PyramidStore {
 public:
  explicit PyramidStore(postgres::Pool& pool) : pool_(pool) {}

  // Unset if it is not made, or if there is no such revision.
  absl::StatusOr<std::optional<StoredPyramid>> Find(const CallContext& context, const SiteId& site, const MapId& map,
                                                    std::int64_t revision) const;
  // The number of the last revision before `revision` that has one; 0: none has.
  absl::StatusOr<std::int64_t> FindBefore(const CallContext& context, const SiteId& site, const MapId& map,
                                          std::int64_t revision) const;
  // The tiles of a revision as it is stored.
  absl::StatusOr<grid::RasterPyramid::Level> ListTiles(const CallContext& context, const SiteId& site, const MapId& map,
                                                       std::int64_t revision) const;
  // Stores the pyramid with those of its blobs that may be missing. Nothing changes if the revision has one already.
  // NOT_FOUND if there is no such revision; FAILED_PRECONDITION if a tile's blob is missing.
  absl::Status Add(const CallContext& context, const SiteId& site, const MapId& map, std::int64_t revision,
                   const StoredPyramid& pyramid, absl::Span<const BlobView> blobs) const;
  // The bytes of those of `sha256` that a pyramid of the site has, by digest.
  absl::StatusOr<std::map<std::string, std::string>> ReadTiles(const CallContext& context, const SiteId& site,
                                                               const std::vector<std::string>& sha256) const;
  // Of the maps after `after` that have a revision, by map; of one level, or of all. NOT_FOUND if there is no such
  // site.
  absl::StatusOr<std::vector<MapThumbnail>> ListThumbnails(const CallContext& context, const SiteId& site,
                                                           std::optional<int> level, const MapId& after,
                                                           int limit) const;

 private:
  postgres::Pool& pool_;
};

}  // namespace enfilade::storage
