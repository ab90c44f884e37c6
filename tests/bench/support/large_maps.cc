// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/support/large_maps.h"

#include <chrono>
#include <random>

#include "core/base/sha256.h"
#include "core/grid/tiled_raster.h"
#include "storage/postgres/maps/blob_store.h"
#include "storage/postgres/maps/revision_store.h"

namespace enfilade::bench {

void Must(const absl::Status& status) {
  if (!status.ok()) throw std::runtime_error(status.ToString());
}

grid::OccupancyGrid RobotsFloor(int side) {
  grid::OccupancyGrid floor;
  floor.geometry = {0.05, {-0.025 * side, -0.025 * side, 0.0}, side, side};
  floor.cells.resize(floor.geometry.cell_count());
  std::mt19937 rng(1);
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      const bool is_wall = row % 150 < 2 || column % 200 < 2 || rng() % 500 == 0;
      floor.cells[floor.geometry.index(column, row)] =
          static_cast<std::uint8_t>(is_wall ? 200 + rng() % 48 : 31 + (rng() % 16 == 0 ? 10 : 0));
    }
  }
  return floor;
}

std::string StoreMap(BenchSystem& system, storage::postgres::Pool& pool, const std::string& name,
                     const std::vector<grid::MapRaster>& rasters) {
  const std::string map = system.CreateMap(name);
  const SiteId site("bench");
  const auto context = [] { return storage::CallContext::WithTimeout(std::chrono::minutes(5)); };
  for (const grid::MapRaster& raster : rasters) {
    const grid::TiledRaster tiled = grid::SplitIntoTiles(raster);
    storage::NewRevision revision;
    revision.source = storage::RevisionSource::kImport;
    revision.geometry = raster.geometry;
    revision.raster_header = tiled.header;
    Sha256Stream content;
    for (const auto& [index, bytes] : tiled.tiles) {
      const std::string sha256 = Sha256(bytes);
      content.Add(sha256);
      Must(storage::postgres::BlobStore(pool).Put(context(), site, {{sha256, bytes}}));
      revision.tiles.push_back({{index.row, index.column}, sha256});
    }
    revision.content_sha256 = content.Finish();
    Must(storage::postgres::RevisionStore(pool)
             .Add(context(), site, MapId(map.substr(map.rfind('/') + 1)), revision, {})
             .status());
  }
  return map;
}

}  // namespace enfilade::bench
