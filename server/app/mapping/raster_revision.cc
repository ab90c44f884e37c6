// SPDX-License-Identifier: Apache-2.0
#include "server/app/mapping/raster_revision.h"

#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "core/grid/overlay.h"
#include "core/grid/tiled_raster.h"

namespace enfilade::server {
namespace {

constexpr std::int64_t kTilePortionBytes = 16 << 20;

}  // namespace

std::string ContentHash(const std::string& header, const std::vector<storage::TileRef>& tiles) {
  Sha256Stream hash;
  hash.Add(Sha256(header));
  for (const storage::TileRef& tile : tiles) {
    hash.Add({reinterpret_cast<const char*>(&tile.key.row), sizeof(tile.key.row)});
    hash.Add({reinterpret_cast<const char*>(&tile.key.column), sizeof(tile.key.column)});
    hash.Add(tile.sha256);
  }
  return hash.Finish();
}

absl::StatusOr<grid::OccupancyGrid> OnMapLattice(const grid::MapRaster& raster, double resolution) {
  absl::StatusOr<grid::OccupancyGrid> grid = grid::ResampleToLattice(grid::ToOccupancyGrid(raster), resolution);
  if (grid.ok()) return grid;
  return FailedPrecondition("the map's raster cannot be resampled to cells of {} m: {}", resolution,
                            std::string(grid.status().message()));
}

absl::StatusOr<RasterRevision> ToRevision(const grid::MapRaster& raster) {
  ENFILADE_RETURN_IF_ERROR(grid::Validate(raster));
  grid::TiledRaster tiled = grid::SplitIntoTiles(raster);
  RasterRevision result;
  result.revision.geometry = raster.geometry;
  result.revision.raster_header = std::move(tiled.header);
  for (auto& [index, bytes] : tiled.tiles) {
    const storage::TileKey key{index.row, index.column};
    std::string sha256 = Sha256(bytes);
    result.revision.tiles.push_back({key, sha256});
    result.tiles.push_back({key, std::move(sha256), std::move(bytes)});
  }
  result.revision.content_sha256 = ContentHash(result.revision.raster_header, result.revision.tiles);
  return result;
}

absl::Status PutTiles(const storage::CallContext& context, const storage::BlobStore& blobs, const SiteId& site,
                      const RasterRevision& raster, const std::set<std::string>& known) {
  std::vector<storage::BlobView> portion;
  std::int64_t bytes = 0;
  for (const storage::Tile& tile : raster.tiles) {
    if (known.contains(tile.sha256)) continue;
    portion.push_back({tile.sha256, tile.data});
    bytes += static_cast<std::int64_t>(tile.data.size());
    if (bytes < kTilePortionBytes) continue;
    ENFILADE_RETURN_IF_ERROR(blobs.Put(context, site, portion));
    portion.clear();
    bytes = 0;
  }
  return portion.empty() ? absl::OkStatus() : blobs.Put(context, site, portion);
}

absl::StatusOr<grid::MapRaster> ReadRaster(const storage::CallContext& context, const storage::RevisionStore& revisions,
                                           const storage::MapRevision& revision) {
  ENFILADE_ASSIGN_OR_RETURN(grid::RasterAssembler assembler, grid::RasterAssembler::Create(revision.raster_header));
  std::optional<storage::TileKey> last;
  std::int64_t missing = revision.tile_count;
  while (missing > 0) {
    ENFILADE_ASSIGN_OR_RETURN(const std::vector<storage::Tile> tiles,
                              revisions.ReadTiles(context, revision, last, kTilePortionBytes));
    if (tiles.empty()) {
      return NotFound("{}/revisions/{} was deleted while it was read", NameOf(revision.site, revision.map),
                      revision.number);
    }
    for (const storage::Tile& tile : tiles) {
      ENFILADE_RETURN_IF_ERROR(assembler.Add({tile.key.row, tile.key.column}, tile.data));
    }
    last = tiles.back().key;
    missing -= static_cast<std::int64_t>(tiles.size());
  }
  return std::move(assembler).Finish();
}

}  // namespace enfilade::server
