// SPDX-License-Identifier: Apache-2.0
// SLAM's cost on a recorded log driven again and again, as JSON on standard output:
//   bench_slam LOG [--laps N] [--no-odometry]
// Every second lap plays the log backwards, so that the drive goes on where it was. Seconds are processor time of this
// process: one core, everything from the scan to the solved graph included, reading the file not.

#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <ctime>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "core/slam/mapper/log_mapper.h"
#include "tests/bench/support/recorded_scans.h"

namespace enfilade::bench {
namespace {

double ProcessorSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

std::int64_t PeakMemory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss * std::int64_t{1024};
}

nlohmann::json Run(std::vector<sensor::PairedScan> scans, int laps) {
  nlohmann::json report;
  report["scans_per_lap"] = scans.size();
  slam::Mapper mapper(slam::SlamOptions{});
  double total = 0.0;
  std::int64_t closures = 0;
  std::int64_t submaps = 0;
  for (int lap = 0; lap < laps; ++lap) {
    const double begin = ProcessorSeconds();
    for (const sensor::PairedScan& scan : scans) mapper.AddScan(scan);
    const slam::SlamDelta delta = mapper.TakeDelta();
    if (lap + 1 == laps) mapper.Finish();
    const double seconds = ProcessorSeconds() - begin;
    const slam::Footprint footprint = mapper.footprint();
    total += seconds;
    for (const slam::SlamSubmap& submap : delta.submaps) submaps = std::max(submaps, submap.id + 1);
    for (const slam::LoopClosure& closure : delta.loop_closures) closures = std::max(closures, closure.id + 1);
    report["laps"].push_back({{"seconds", seconds},
                              {"ms_per_scan", 1e3 * seconds / static_cast<double>(scans.size())},
                              {"submaps", submaps},
                              {"closures_tried", closures},
                              {"working_bytes", footprint.working},
                              {"kept_bytes", footprint.kept},
                              {"peak_memory_bytes", PeakMemory()}});
    std::reverse(scans.begin(), scans.end());
  }
  report["seconds"] = total;
  report["scans_per_second"] = static_cast<double>(scans.size()) * laps / total;
  return report;
}

}  // namespace
}  // namespace enfilade::bench

int main(int argc, char** argv) {
  CLI::App app("SLAM's cost on a recorded log");
  std::string log;
  int laps = 1;
  bool no_odometry = false;
  app.add_option("LOG", log, "The log")->required();
  app.add_option("--laps", laps, "How often it is driven")->capture_default_str();
  app.add_flag("--no-odometry", no_odometry, "Use the scans only");
  CLI11_PARSE(app, argc, argv);
  auto scans = enfilade::bench::ReadPairedScans(log, !no_odometry);
  if (!scans.ok()) {
    std::cerr << "bench_slam: " << scans.status().message() << '\n';
    return 1;
  }
  std::cout << enfilade::bench::Run(*std::move(scans), laps).dump(2) << '\n';
  return 0;
}
