// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "core/grid/map_raster.h"
#include "core/grid/occupancy_grid.h"
#include "storage/postgres/driver/pool.h"
#include "tests/bench/support/bench_system.h"

namespace enfilade::bench {

template <typename T>
T Must(absl::StatusOr<T> value) {
  if (!value.ok()) throw std::runtime_error(value.status().ToString());
  return *std::move(value);
}
void Must(const absl::Status& status);

// As robots make it: `side` x `side` cells of 0.05 m, rooms of 10 m x 7.5 m with rough walls, free inside with some
// clutter.
grid::OccupancyGrid RobotsFloor(int side);

// A map with the rasters as revisions 1, 2, ... Gives its resource name.
std::string StoreMap(BenchSystem& system, storage::postgres::Pool& pool, const std::string& name,
                     const std::vector<grid::MapRaster>& rasters);

}  // namespace enfilade::bench
