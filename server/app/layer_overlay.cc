#include "server/app/layer_overlay.h"

#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/grid/overlay.h"
#include "core/grid/tiled_raster.h"
#include "server/app/raster_revision.h"

namespace enfilade::server {
namespace {

absl::StatusOr<OccupancyGrid> LaidOverOrTooFar(const OccupancyGrid& under, const OccupancyGrid& over) {
  absl::StatusOr<OccupancyGrid> grid = LaidOver(under, over);
  if (grid.ok()) return grid;
  return FailedPrecondition("the map's layers do not fit into one raster: {}", std::string(grid.status().message()));
}

}  // namespace

absl::StatusOr<OccupancyGrid> LayerOverlay::Lay(const CallContext& context, const LayersBeside& beside,
                                                const OccupancyGrid& own) {
  const double resolution = own.geometry.resolution;
  std::map<std::string, OccupancyGrid> used;
  OccupancyGrid grid;
  for (const MapLayer& layer : beside.below) {
    ENFILADE_ASSIGN_OR_RETURN(const OccupancyGrid* const other, Read(context, layer, resolution, used));
    ENFILADE_ASSIGN_OR_RETURN(grid, LaidOverOrTooFar(grid, *other));
  }
  ENFILADE_ASSIGN_OR_RETURN(grid, LaidOverOrTooFar(grid, own));
  for (const MapLayer& layer : beside.above) {
    ENFILADE_ASSIGN_OR_RETURN(const OccupancyGrid* const other, Read(context, layer, resolution, used));
    ENFILADE_ASSIGN_OR_RETURN(grid, LaidOverOrTooFar(grid, *other));
  }
  grids_ = std::move(used);
  return grid;
}

absl::StatusOr<const OccupancyGrid*> LayerOverlay::Read(const CallContext& context, const MapLayer& layer,
                                                        double resolution, std::map<std::string, OccupancyGrid>& used) {
  const std::string hash = ContentHash(layer.raster.header, layer.raster.tiles);
  if (auto known = grids_.extract(hash)) return &used.insert(std::move(known)).position->second;
  ENFILADE_ASSIGN_OR_RETURN(RasterAssembler assembler, RasterAssembler::Create(layer.raster.header));
  for (const TileRef& tile : layer.raster.tiles) {
    ENFILADE_ASSIGN_OR_RETURN(const std::string bytes, blobs_.Get(context, site_, tile.sha256));
    ENFILADE_RETURN_IF_ERROR(assembler.Add({tile.key.row, tile.key.column}, bytes));
  }
  ENFILADE_ASSIGN_OR_RETURN(OccupancyGrid grid, OnMapLattice(std::move(assembler).Finish(), resolution));
  return &used.insert_or_assign(hash, std::move(grid)).first->second;
}

}  // namespace enfilade::server
