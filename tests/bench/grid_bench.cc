// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "core/grid/files/grey_image.h"
#include "core/grid/files/json_map.h"
#include "core/grid/files/pgm_codec.h"
#include "core/grid/log_odds_grid.h"
#include "core/grid/tiled_raster.h"

namespace enfilade::bench {
namespace {

// Scans of 180 beams over 180 degrees from poses along a path, in a space whose walls are `range` m away on average.
std::vector<grid::ScanRays> Scans(double range) {
  std::mt19937 rng(7);
  std::uniform_real_distribution<double> share(0.5, 1.0);
  std::vector<grid::ScanRays> scans;
  for (int i = 0; i < 200; ++i) {
    grid::ScanRays rays;
    rays.origin = {0.05 * i, 3.0 * std::sin(0.05 * i)};
    const double yaw = 0.03 * i;
    for (int beam = 0; beam < 180; ++beam) {
      const double angle = yaw + (beam - 90) * M_PI / 180.0;
      rays.hits.push_back(rays.origin + range * share(rng) / 0.75 * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    }
    scans.push_back(rays);
  }
  return scans;
}

void CastScans(benchmark::State& state) {
  const std::vector<grid::ScanRays> scans = Scans(static_cast<double>(state.range(0)));
  grid::LogOddsGrid grid(0.05, {});
  for (const grid::ScanRays& rays : scans) grid.Insert(rays).IgnoreError();  // grown before the clock runs
  std::size_t next = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(grid.Insert(scans[next]));
    next = (next + 1) % scans.size();
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(CastScans)->ArgName("mean_range_m")->Arg(5)->Arg(10)->Arg(22)->Unit(benchmark::kMicrosecond);

void RenderLogOddsGrid(benchmark::State& state) {
  grid::LogOddsGrid grid(0.05, {});
  for (const grid::ScanRays& rays : Scans(22.0)) grid.Insert(rays).IgnoreError();
  std::int64_t cells = 0;
  for (auto _ : state) cells += static_cast<std::int64_t>(grid.ToOccupancyGrid().cells.size());
  state.SetBytesProcessed(cells);
}
BENCHMARK(RenderLogOddsGrid)->Unit(benchmark::kMillisecond);

// 64 million cells (8000 x 8000: 400 m at 0.05 m) of a map as robots make it: rooms of 200 x 150 cells with rough
// walls, free inside with some clutter, and two thirds of the area unknown.
const grid::OccupancyGrid& LargeGrid() {
  static const grid::OccupancyGrid grid = [] {
    grid::OccupancyGrid large;
    large.geometry = {.resolution = 0.05, .T_map_grid = {-200.0, -200.0, 0.0}, .width = 8000, .height = 8000};
    large.cells.assign(large.geometry.cell_count(), grid::kUnknownCell);
    std::mt19937 rng(1);
    for (int room_row = 0; room_row < 53; ++room_row) {
      for (int room_column = 0; room_column < 40; ++room_column) {
        if (rng() % 3 != 0) continue;
        for (int row = 0; row < 150; ++row) {
          for (int column = 0; column < 200; ++column) {
            const bool is_wall = row < 2 || column < 2 || row > 147 || column > 197 || rng() % 500 == 0;
            const auto cell = static_cast<std::uint8_t>(is_wall ? 200 + rng() % 48 : 31 + (rng() % 16 == 0 ? 40 : 0));
            large.cells[large.geometry.index(room_column * 200 + column, room_row * 150 + row)] = cell;
          }
        }
      }
    }
    return large;
  }();
  return grid;
}

grid::GreyCells LargeGrey() { return grid::SaveAsGrey(LargeGrid().cells, {}); }

void CountBytes(benchmark::State& state, std::size_t bytes) {
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(bytes));
}

void SaveGridAsGrey(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(LargeGrey());
  CountBytes(state, LargeGrid().cells.size());
}
BENCHMARK(SaveGridAsGrey)->Unit(benchmark::kMillisecond);

void EncodePgmFile(benchmark::State& state) {
  const grid::GreyCells cells = LargeGrey();
  const grid::PgmFrame frame{.width = 8000, .height = 8000, .max_value = 255, .header = {}, .trailer = {}};
  for (auto _ : state) benchmark::DoNotOptimize(grid::EncodePgm(frame, cells.grey));
  CountBytes(state, cells.grey.size());
}
BENCHMARK(EncodePgmFile)->Unit(benchmark::kMillisecond);

void DecodePgmFile(benchmark::State& state) {
  const grid::GreyCells cells = LargeGrey();
  const std::string bytes =
      grid::EncodePgm({.width = 8000, .height = 8000, .max_value = 255, .header = {}, .trailer = {}}, cells.grey);
  for (auto _ : state) benchmark::DoNotOptimize(grid::DecodePgm(bytes));
  CountBytes(state, bytes.size());
}
BENCHMARK(DecodePgmFile)->Unit(benchmark::kMillisecond);

void EncodePngFile(benchmark::State& state) {
  const grid::GreyCells cells = LargeGrey();
  for (auto _ : state) benchmark::DoNotOptimize(grid::EncodeGreyPng(cells, 8000, 8000));
  CountBytes(state, cells.grey.size());
}
BENCHMARK(EncodePngFile)->Unit(benchmark::kMillisecond);

void DecodePngFile(benchmark::State& state) {
  const grid::GreyCells cells = LargeGrey();
  const std::string bytes = grid::EncodeGreyPng(cells, 8000, 8000).value();
  for (auto _ : state) benchmark::DoNotOptimize(grid::DecodeGreyPng(bytes, grid::MapDialect::kNav2));
  CountBytes(state, cells.grey.size());
}
BENCHMARK(DecodePngFile)->Unit(benchmark::kMillisecond);

// Bytes are those of the JSON text.
std::string JsonText() {
  std::mt19937_64 rng(2);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<double> values(2000 * 2000);
  for (double& value : values) value = unit(rng);
  return grid::FormatJsonMap({-15, 14.985, -15, 14.985, 0.015, 0.015, 10}, values);
}

void ParseJsonFile(benchmark::State& state) {
  const std::string text = JsonText();
  for (auto _ : state) benchmark::DoNotOptimize(grid::ParseJsonMap(text));
  CountBytes(state, text.size());
}
BENCHMARK(ParseJsonFile)->Unit(benchmark::kMillisecond);

void FormatJsonFile(benchmark::State& state) {
  const std::string text = JsonText();
  const grid::MapRaster raster = grid::ParseJsonMap(text).value().raster;
  const auto& cells = std::get<grid::UnitCells>(raster.cells);
  for (auto _ : state) benchmark::DoNotOptimize(grid::FormatJsonMap(cells.limits, cells.values));
  CountBytes(state, text.size());
}
BENCHMARK(FormatJsonFile)->Unit(benchmark::kMillisecond);

void SplitRaster(benchmark::State& state) {
  const grid::MapRaster raster = grid::FromOccupancyGrid(LargeGrid());
  std::size_t packed = 0;
  for (auto _ : state) {
    const grid::TiledRaster tiled = grid::SplitIntoTiles(raster);
    packed = 0;
    for (const auto& [index, bytes] : tiled.tiles) packed += bytes.size();
  }
  CountBytes(state, LargeGrid().cells.size());
  state.counters["packed_bytes"] = static_cast<double>(packed);
}
BENCHMARK(SplitRaster)->Unit(benchmark::kMillisecond);

void JoinRaster(benchmark::State& state) {
  const grid::TiledRaster tiled = grid::SplitIntoTiles(grid::FromOccupancyGrid(LargeGrid()));
  for (auto _ : state) {
    grid::RasterAssembler assembler = grid::RasterAssembler::Create(tiled.header).value();
    for (const auto& [index, bytes] : tiled.tiles) {
      if (!assembler.Add(index, bytes).ok()) std::abort();
    }
    benchmark::DoNotOptimize(std::move(assembler).Finish());
  }
  CountBytes(state, LargeGrid().cells.size());
}
BENCHMARK(JoinRaster)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace enfilade::bench

BENCHMARK_MAIN();
