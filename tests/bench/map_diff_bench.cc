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

#include "core/grid/files/grey_image.h"
#include "core/grid/map_raster.h"
#include "enfilade/v1/map_service.grpc.pb.h"
#include "nlohmann/json.hpp"
#include "tests/bench/support/bench_system.h"
#include "tests/bench/support/large_maps.h"

namespace {

using namespace enfilade;
using namespace enfilade::bench;
using Clock = std::chrono::steady_clock;

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
  const grid::OccupancyGrid floor = RobotsFloor(side);
  const grid::OccupancyGrid edited = Edited(floor);
  const std::string few =
      StoreMap(system, *pool, "Few", {grid::FromOccupancyGrid(floor), grid::FromOccupancyGrid(edited)});
  const std::string all =
      StoreMap(system, *pool, "All", {grid::FromOccupancyGrid(floor), grid::FromOccupancyGrid(SeenAgain(floor))});
  const std::string grey = StoreMap(system, *pool, "Grey", {ToGrey(floor), ToGrey(edited)});
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
