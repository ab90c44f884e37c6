// SPDX-License-Identifier: Apache-2.0
// bench_perception DATA: image matching and cloud registration on recordings, as one JSON document on stdout.
#include "tests/bench/perception_bench.h"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <fstream>
#include <iostream>
#include <sstream>
#include <vector>

namespace enfilade::bench {

std::string ReadAll(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream bytes;
  bytes << file.rdbuf();
  return std::move(bytes).str();
}

namespace {

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

nlohmann::json Time(int repeats, const std::function<void()>& work) {
  std::vector<double> times;
  std::vector<double> processor;
  for (int i = 0; i < repeats; ++i) {
    const std::clock_t processor_start = std::clock();
    const auto start = std::chrono::steady_clock::now();
    work();
    times.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    processor.push_back(1000.0 * static_cast<double>(std::clock() - processor_start) / CLOCKS_PER_SEC);
  }
  return {{"ms", Median(times)}, {"processor_ms", Median(processor)}};
}

}  // namespace enfilade::bench

int main(int argc, char** argv) {
  using namespace enfilade::bench;
  if (argc != 2 || !std::filesystem::is_directory(argv[1])) {
    std::cerr << "usage: bench_perception DATA, the folder of the recordings\n";
    return 2;
  }
  const std::filesystem::path data = argv[1];
  const nlohmann::json document = {{"corridor", MeasureCorridor(data)},
                                   {"simulated_corridors", MeasureSimulatedCorridors()},
                                   {"wide_baselines", MeasureWideBaselines(data)},
                                   {"overlaps", MeasureOverlaps(data)},
                                   {"clouds", MeasureClouds(data)}};
  std::cout << document.dump(2) << '\n';
}
