#include <benchmark/benchmark.h>

#include <cmath>
#include <random>
#include <vector>

#include "core/grid/log_odds_grid.h"

namespace enfilade {
namespace {

// Scans of 180 beams over 180 degrees from poses along a path, in a space whose walls are `range` m away on average.
std::vector<ScanRays> Scans(double range) {
  std::mt19937 rng(7);
  std::uniform_real_distribution<double> share(0.5, 1.0);
  std::vector<ScanRays> scans;
  for (int i = 0; i < 200; ++i) {
    ScanRays rays;
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
  const std::vector<ScanRays> scans = Scans(static_cast<double>(state.range(0)));
  LogOddsGrid grid(0.05, {});
  for (const ScanRays& rays : scans) grid.Insert(rays).IgnoreError();  // grown before the clock runs
  std::size_t next = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(grid.Insert(scans[next]));
    next = (next + 1) % scans.size();
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(CastScans)->ArgName("mean_range_m")->Arg(5)->Arg(10)->Arg(22)->Unit(benchmark::kMicrosecond);

void RenderLogOddsGrid(benchmark::State& state) {
  LogOddsGrid grid(0.05, {});
  for (const ScanRays& rays : Scans(22.0)) grid.Insert(rays).IgnoreError();
  std::int64_t cells = 0;
  for (auto _ : state) cells += static_cast<std::int64_t>(grid.ToOccupancyGrid().cells.size());
  state.SetBytesProcessed(cells);
}
BENCHMARK(RenderLogOddsGrid)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace enfilade

BENCHMARK_MAIN();
