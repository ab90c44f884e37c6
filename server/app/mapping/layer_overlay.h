// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/grid/occupancy_grid.h"
#include "storage/blob_store.h"
#include "storage/call_context.h"
#include "storage/revision_store.h"

namespace enfilade::server {

// Lays a session's raster between the other layers of its map. Keeps what it has read of them until they change.
class LayerOverlay {
 public:
  LayerOverlay(const storage::BlobStore& blobs, SiteId site) : blobs_(blobs), site_(std::move(site)) {}

  // `own` lies on the lattice of its resolution. FAILED_PRECONDITION where layers lie too far apart for one raster.
  absl::StatusOr<grid::OccupancyGrid> Lay(const storage::CallContext& context, const storage::LayersBeside& beside,
                                          const grid::OccupancyGrid& own);

 private:
  absl::StatusOr<const grid::OccupancyGrid*> Read(const storage::CallContext& context, const storage::MapLayer& layer,
                                                  double resolution, std::map<std::string, grid::OccupancyGrid>& used);

  const storage::BlobStore& blobs_;
  const SiteId site_;
  std::map<std::string, grid::OccupancyGrid> grids_;  // by what they were read from
};

}  // namespace enfilade::server
