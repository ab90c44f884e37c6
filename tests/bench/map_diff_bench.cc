// SPDX-License-Identifier: Apache-2.0
// Prints JSON: how long DiffMapRevisions takes between two revisions of 4,000 x 4,000 cells (200 m x 200 m), by gRPC.
// usage: bench_map_diff [--quick]
#include <algorithm>
#include <chrono>
#include <iostream>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/base/sha256.h"
#include "core/grid/files/grey_image.h"
#include "core/grid/map_raster.h"
#include "core/grid/tiled_raster.h"
#include "enfilade/v1/map_service.grpc.pb.h"
#include "fmt/format.h"
#include "nlohmann/json.hpp"
#include "storage/postgres/maps/blob_store.h"
#include "storage/postgres/maps/revision_store.h"
#include "tests/bench/support/bench_system.h"

namespace {

using namespace enfilade;
using namespace enfilade::bench;
using Clock = std::chrono::steady_clock;

template <typename T>
T Must(absl::StatusOr<T> value) {
  if (!value.ok()) throw std::runtime_error(value.status().ToString());
  return *std::move(value);
}
void Must(const absl::Status& status) {
  if (!status.ok()) throw std::runtime_error(status.ToString());
}

// As robots make it: rooms of 10 m x 7.5 m with rough walls, free inside with some clutter.
grid::OccupancyGrid Floor(int side) {
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

// 200 strokes of 2 m.
grid::OccupancyGrid Edited(grid::OccupancyGrid floor) {
  std::mt19937 rng(2);
  const auto side = static_cast<unsigned>(floor.geometry.width);
  for (int stroke = 0; stroke < 200; ++stroke) {
    const auto begin = floor.geometry.index(static_cast<int>(rng() % (side - 40)), static_cast<int>(rng() % side));
    std::fill_n(floor.cells.begin() + static_cast<std::ptrdiff_t>(begin), 40, stroke % 2 == 0 ? 250 : 10);
  }
  return floor;
}

// Everything was seen again: no tile is what it was, and one cell of ten thousand has another class.
grid::OccupancyGrid SeenAgain(grid::OccupancyGrid floor) {
  std::mt19937 rng(3);
  for (std::uint8_t& cell : floor.cells) {
    if (rng() % 8 == 0) ++cell;
    if (rng() % 10'000 == 0) cell = static_cast<std::uint8_t>(255 - cell);
  }
  return floor;
}

grid::MapRaster ToGrey(const grid::OccupancyGrid& floor) { return {floor.geometry, grid::SaveAsGrey(floor.cells, {})}; }

// A map with the revisions 1 and 2. Gives its resource name.
std::string Store(BenchSystem& system, storage::postgres::Pool& pool, const std::string& name,
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

struct Wanted {
  bool picture = false;
  bool geojson = false;
};

nlohmann::json Measure(const client::Connection& connection, const std::string& map, Wanted wanted, int rounds) {
  v1::DiffMapRevisionsRequest request;
  request.set_base(map + "/revisions/1");
  request.set_revision(map + "/revisions/2");
  request.set_with_picture(wanted.picture);
  request.set_with_geojson(wanted.geojson);
  std::vector<double> times;
  v1::DiffMapRevisionsResponse response;
  for (int round = 0; round < rounds; ++round) {
    const auto begin = Clock::now();
    response = Must(connection.Call(&v1::MapService::Stub::DiffMapRevisions, request));
    times.push_back(std::chrono::duration<double, std::milli>(Clock::now() - begin).count());
  }
  std::sort(times.begin(), times.end());
  return {{"p50_ms", times[times.size() / 2]},
          {"min_ms", times.front()},
          {"max_ms", times.back()},
          {"regions", response.region_count()},
          {"answer_bytes", response.ByteSizeLong()}};
}

nlohmann::json Run(int side, int rounds) {
  BenchSystem system({"mapping.workers=0"});
  const auto pool = Must(storage::postgres::Pool::Create({.url = system.database_url()}));
  const client::Connection connection = system.server().Connect();
  const grid::OccupancyGrid floor = Floor(side);
  const grid::OccupancyGrid edited = Edited(floor);
  const std::string few =
      Store(system, *pool, "Few", {grid::FromOccupancyGrid(floor), grid::FromOccupancyGrid(edited)});
  const std::string all =
      Store(system, *pool, "All", {grid::FromOccupancyGrid(floor), grid::FromOccupancyGrid(SeenAgain(floor))});
  const std::string grey = Store(system, *pool, "Grey", {ToGrey(floor), ToGrey(edited)});
  return {{"benchmark", "differences of revisions"},
          {"cells", std::int64_t{side} * side},
          {"rounds", rounds},
          {"edited", Measure(connection, few, {}, rounds)},
          {"edited, with GeoJSON", Measure(connection, few, {.geojson = true}, rounds)},
          {"edited, with picture", Measure(connection, few, {.picture = true}, rounds)},
          {"every tile changed", Measure(connection, all, {}, rounds)},
          {"edited images", Measure(connection, grey, {}, rounds)}};
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const bool quick = argc > 1 && std::string(argv[1]) == "--quick";
    std::cout << Run(quick ? 1000 : 4000, quick ? 3 : 21).dump(2) << '\n';
  } catch (const std::exception& failure) {
    std::cerr << "bench_map_diff: " << failure.what() << '\n';
    return 1;
  }
}
