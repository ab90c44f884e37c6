// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <string>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/grid/map_raster.h"
#include "core/grid/occupancy_grid.h"
#include "storage/call_context.h"
#include "storage/maps/blob_store.h"
#include "storage/maps/revision_store.h"

namespace enfilade::server {

// A layer as it is stored. DATA_LOSS.
absl::StatusOr<grid::MapRaster> ReadRaster(const storage::CallContext& context, const storage::BlobStore& blobs,
                                           const SiteId& site, const storage::StoredRaster& raster);

// A layer on the lattice of the map's frame, with cells of `resolution` m. Errors as OnMapLattice; DATA_LOSS.
absl::StatusOr<grid::OccupancyGrid> ReadLayer(const storage::CallContext& context, const storage::BlobStore& blobs,
                                              const SiteId& site, const storage::StoredRaster& raster,
                                              double resolution);

// Overlays the layers of a map, with one session's raster among them. Caches the other layers until they change.
class LayerOverlay {
 public:
  LayerOverlay(const storage::BlobStore& blobs, SiteId site) : blobs_(blobs), site_(std::move(site)) {}

  // Without hits in areas where they are ignored. `own` is the session's raster, on the lattice of its resolution.
  // FAILED_PRECONDITION if the layers are too far apart for one raster.
  absl::StatusOr<grid::OccupancyGrid> Compose(const storage::CallContext& context, const storage::LayersBeside& beside,
                                              const grid::OccupancyGrid& own);
  // A layer that need not be read, on the lattice of the resolution for which Compose is called next.
  void Keep(const storage::StoredRaster& layer, grid::OccupancyGrid grid);

  // Memory held, about.
  std::size_t bytes() const;

 private:
  absl::StatusOr<const grid::OccupancyGrid*> Read(const storage::CallContext& context, const storage::MapLayer& layer,
                                                  double resolution, std::map<std::string, grid::OccupancyGrid>& used);

  const storage::BlobStore& blobs_;
  const SiteId site_;
  std::map<std::string, grid::OccupancyGrid> grids_;  // of the last call, by ContentHash
};

}  // namespace enfilade::server
