// SPDX-License-Identifier: Apache-2.0
// Prints JSON: acknowledged scans per second beside a bare COPY of the same rows, and the server's memory while the
// database stands still. usage: bench_ingest [--quick]
#include <algorithm>
#include <iostream>

#include "nlohmann/json.hpp"
#include "tests/bench/support/bare_copy.h"
#include "tests/bench/support/bench_system.h"
#include "tests/bench/support/load_generator.h"
#include "tests/bench/support/server_memory.h"

namespace {

using namespace enfilade;
using namespace enfilade::bench;

struct Scenario {
  int robots;
  int scans_per_robot;
  int batch_records;
  int window;
};
// One robot sends what it has spooled; many send what they record.
constexpr Scenario kScenarios[] = {{1, 50'000, 1000, 8}, {10, 5'000, 200, 8}, {100, 600, 50, 4}};

nlohmann::json Measure(BenchSystem& system, BareCopy& bare, const Scenario& scenario, int rounds) {
  const std::vector<enfilade::sensor::Record> records = RandomScans(scenario.scans_per_robot, 1);
  const std::vector<LoadBatch> batches = ToBatches(records, scenario.batch_records);
  const double scans = static_cast<double>(scenario.robots) * scenario.scans_per_robot;
  std::vector<double> served;
  std::vector<double> copied;
  std::vector<double> ratios;
  std::vector<double> latencies;
  for (int round = 0; round < rounds; ++round) {
    const std::vector<std::string> sessions = system.CreateSessions(scenario.robots);
    const double copy_before = scans / bare.Run(sessions, records);
    LoadResult load =
        LoadGenerator({.address = system.server().address(), .sessions = sessions, .window = scenario.window}, batches)
            .Run();
    if (!load.error.empty() || load.acknowledged != static_cast<std::int64_t>(scans)) {
      throw std::runtime_error("not everything was acknowledged: " + load.error);
    }
    const double copy_after = scans / bare.Run(sessions, records);
    copied.push_back((copy_before + copy_after) / 2.0);
    served.push_back(scans / load.seconds);
    ratios.push_back(served.back() / copied.back());
    latencies.insert(latencies.end(), load.latency_ms.begin(), load.latency_ms.end());
    std::cerr << scenario.robots << " robots: " << served.back() << " scans/s, COPY " << copied.back() << "\n";
  }
  return {{"robots", scenario.robots},
          {"scans", scans},
          {"batch_scans", scenario.batch_records},
          {"window_batches", scenario.window},
          {"rounds", rounds},
          {"scans_per_s", Percentile(served, 0.5)},
          {"copy_scans_per_s", Percentile(copied, 0.5)},
          {"ratio", Percentile(ratios, 0.5)},
          {"ratio_min", Percentile(ratios, 0.0)},
          {"ratio_max", Percentile(ratios, 1.0)},
          {"acknowledgement_p50_ms", Percentile(latencies, 0.5)},
          {"acknowledgement_p99_ms", Percentile(latencies, 0.99)}};
}

}  // namespace

int main(int argc, char** argv) {
  const bool quick = argc > 1 && std::string(argv[1]) == "--quick";
  try {
    BenchSystem system({"mapping.workers=0"});
    BareCopy bare(system.database_url());
    nlohmann::json document = {{"benchmark", "ingest"}, {"beams", 180}};
    for (const Scenario& scenario : kScenarios) {
      document["throughput"].push_back(Measure(system, bare, scenario, quick ? 1 : 5));
    }
    if (!quick) document["memory"] = MeasureServerMemory(system);
    std::cout << document.dump(2) << '\n';
  } catch (const std::exception& failure) {
    std::cerr << "bench_ingest: " << failure.what() << '\n';
    return 1;
  }
}
