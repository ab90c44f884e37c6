// SPDX-License-Identifier: Apache-2.0
// SLAM's cost on a recorded log driven again and again, as JSON on standard output:
//   bench_slam LOG [--laps N] [--no-odometry]
// Every second lap plays the log backwards, so that the drive goes on where it was. Seconds are processor time of this
// process: one core, everything from the scan to the solved graph included, reading the file not. Also: drawing the map
// (median of 5), and joining the first lap as 30 sessions that were mapped before (slam::SessionChain).

#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <ctime>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "core/slam/mapper/map_renderer.h"
#include "core/slam/mapper/mapper.h"
#include "core/slam/mapper/session_chain.h"
#include "tests/bench/support/recorded_scans.h"

namespace enfilade::bench {
namespace {

double ProcessorSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

std::int64_t PeakMemory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss * std::int64_t{1024};
}

double SecondsToRender(const slam::Mapper& mapper) {
  constexpr int kTimes = 5;
  std::vector<double> seconds;
  for (int i = 0; i < kTimes; ++i) {
    const slam::SlamOptions options;
    slam::MapRenderer renderer(options.resolution, slam::LogOddsOptionsOf(options.occupancy));
    const double begin = ProcessorSeconds();
    mapper.RenderGrid(renderer);
    seconds.push_back(ProcessorSeconds() - begin);
  }
  std::sort(seconds.begin(), seconds.end());
  return seconds[kTimes / 2];
}

// The scans as so many sessions, each mapped on its own.
std::vector<slam::ChainedSession> MapSessions(const std::vector<sensor::PairedScan>& scans, std::size_t count) {
  std::vector<slam::ChainedSession> sessions(count);
  for (std::size_t i = 0; i < count; ++i) {
    slam::Mapper mapper(slam::SlamOptions{});
    for (std::size_t k = i * scans.size() / count; k < (i + 1) * scans.size() / count; ++k) {
      const slam::ScanReport report = mapper.AddScan(scans[k]);
      if (report.keyframe) sessions[i].scans.push_back(scans[k]);
    }
    mapper.Finish();
    sessions[i].map.Apply(mapper.TakeDelta());
  }
  return sessions;
}

nlohmann::json JoinSessions(const std::vector<sensor::PairedScan>& scans) {
  constexpr std::size_t kSessions = 30;
  const std::vector<slam::ChainedSession> sessions = MapSessions(scans, kSessions);
  slam::SessionChain chain(slam::SlamOptions{}, std::nullopt);
  const double begin = ProcessorSeconds();
  for (const slam::ChainedSession& session : sessions) {
    if (!chain.Append(session).ok()) return nullptr;
  }
  const double appended = ProcessorSeconds();
  chain.Finish();
  return {{"sessions", kSessions},
          {"seconds_to_append", appended - begin},
          {"seconds_to_finish", ProcessorSeconds() - appended}};
}

nlohmann::json Run(std::vector<sensor::PairedScan> scans, int laps) {
  nlohmann::json report;
  report["scans_per_lap"] = scans.size();
  report["joined"] = JoinSessions(scans);
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
  report["seconds_to_render"] = SecondsToRender(mapper);
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
