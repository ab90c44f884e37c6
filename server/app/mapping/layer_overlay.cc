// SPDX-License-Identifier: Apache-2.0
#include "server/app/mapping/layer_overlay.h"

#include <span>
#include <utility>
#include <vector>

#include "core/areas/ignore_hits.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/grid/overlay.h"
#include "core/grid/tiled_raster.h"
#include "server/app/mapping/raster_revision.h"

namespace enfilade::server {
namespace {

absl::StatusOr<grid::OccupancyGrid> OverlayOrTooFar(std::span<const grid::OccupancyGrid* const> layers) {
  absl::StatusOr<grid::OccupancyGrid> grid = grid::OverlayAll(layers);
  if (grid.ok()) return grid;
  return FailedPrecondition("the map's layers are too far apart for one raster: {}",
                            std::string(grid.status().message()));
}

}  // namespace

absl::StatusOr<grid::MapRaster> ReadRaster(const storage::CallContext& context, const storage::BlobStore& blobs,
                                           const SiteId& site, const storage::StoredRaster& raster) {
  ENFILADE_ASSIGN_OR_RETURN(grid::RasterAssembler assembler, grid::RasterAssembler::Create(raster.header));
  for (const storage::TileRef& tile : raster.tiles) {
    ENFILADE_ASSIGN_OR_RETURN(const std::string bytes, blobs.Get(context, site, tile.sha256));
    ENFILADE_RETURN_IF_ERROR(assembler.Add({tile.key.row, tile.key.column}, bytes));
  }
  return std::move(assembler).Finish();
}

absl::StatusOr<grid::OccupancyGrid> ReadLayer(const storage::CallContext& context, const storage::BlobStore& blobs,
                                              const SiteId& site, const storage::StoredRaster& raster,
                                              double resolution) {
  ENFILADE_ASSIGN_OR_RETURN(const grid::MapRaster stored, ReadRaster(context, blobs, site, raster));
  return OnMapLattice(stored, resolution);
}

absl::StatusOr<grid::OccupancyGrid> LayerOverlay::Compose(const storage::CallContext& context,
                                                          const storage::LayersBeside& beside,
                                                          const grid::OccupancyGrid& own) {
  const double resolution = own.geometry.resolution;
  std::map<std::string, grid::OccupancyGrid> used;
  std::vector<const grid::OccupancyGrid*> layers;
  for (const storage::MapLayer& layer : beside.below) {
    ENFILADE_ASSIGN_OR_RETURN(layers.emplace_back(), Read(context, layer, resolution, used));
  }
  layers.push_back(&own);
  for (const storage::MapLayer& layer : beside.above) {
    ENFILADE_ASSIGN_OR_RETURN(layers.emplace_back(), Read(context, layer, resolution, used));
  }
  ENFILADE_ASSIGN_OR_RETURN(grid::OccupancyGrid grid, OverlayOrTooFar(layers));
  grids_ = std::move(used);
  areas::IgnoreHits(beside.ignored, grid);
  return grid;
}

void LayerOverlay::Keep(const storage::StoredRaster& layer, grid::OccupancyGrid grid) {
  grids_.insert_or_assign(ContentHash(layer.header, layer.tiles), std::move(grid));
}

std::size_t LayerOverlay::bytes() const {
  std::size_t bytes = 0;
  for (const auto& [hash, grid] : grids_) bytes += hash.capacity() + grid.cells.capacity();
  return bytes;
}

absl::StatusOr<const grid::OccupancyGrid*> LayerOverlay::Read(const storage::CallContext& context,
                                                              const storage::MapLayer& layer, double resolution,
                                                              std::map<std::string, grid::OccupancyGrid>& used) {
  const std::string hash = ContentHash(layer.raster.header, layer.raster.tiles);
  if (auto known = grids_.extract(hash)) return &used.insert(std::move(known)).position->second;
  ENFILADE_ASSIGN_OR_RETURN(grid::OccupancyGrid grid, ReadLayer(context, blobs_, site_, layer.raster, resolution));
  return &used.insert_or_assign(hash, std::move(grid)).first->second;
}

}  // namespace enfilade::server
