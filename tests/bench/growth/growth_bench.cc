// SPDX-License-Identifier: Apache-2.0
// Prints JSON: how long calls take as sites, and their number, grow (docs/benchmarks.md). usage: bench_growth [--quick]
// [MAPS...]
#include <iostream>
#include <stdexcept>

#include "fmt/format.h"
#include "nlohmann/json.hpp"
#include "tests/bench/growth/big_site.h"
#include "tests/bench/growth/site_calls.h"
#include "tests/bench/support/load_generator.h"

namespace enfilade::bench {
namespace {

constexpr int kSessions = 8;  // of the drive, for door verdicts
constexpr std::uint64_t kBuilding = 9101;

struct Counts {
  int reads = 300;
  int writes = 30;
};

nlohmann::json Summary(std::vector<double> values) {
  const std::size_t count = values.size();
  return {{"calls", count}, {"p50_ms", Percentile(values, 0.5)}, {"p99_ms", Percentile(values, 0.99)}};
}

nlohmann::json MeasureSite(BenchSystem& system, const std::string& site, int maps, const RecordedDrive& drive,
                           const Counts& counts) {
  SiteCalls calls(system, site, maps);
  nlohmann::json times;
  const auto add = [&](const char* name, std::vector<double> values) {
    times[name] = Summary(std::move(values));
    std::cerr << fmt::format("  {}: {}\n", name, times[name].dump());
  };
  add("GetSite", calls.GetSite(counts.reads));
  add("FindLinkPoints", calls.FindLinkPoints(counts.reads));
  add("GetGlobalPose", calls.GetGlobalPose(counts.reads));
  add("SubmitScan", calls.SubmitScan(counts.reads));
  add("StreamRecords", calls.StreamRecords(counts.reads));
  add("pose after a change", calls.PoseAfterChange(counts.writes));
  add("new room", calls.NewRoom(counts.writes));
  calls.Settle();
  add("door verdict", calls.DoorVerdict(drive, kSessions));
  return times;
}

// Sites of `sizes` maps and, unless `sizes` is given, servers with more and more sites.
nlohmann::json Run(bool quick, std::vector<int> sizes) {
  const Counts counts = quick ? Counts{100, 10} : Counts{};
  const bool all = sizes.empty();
  if (all) sizes = quick ? std::vector{100, 1'000, 10'000} : std::vector{100, 1'000, 10'000, 100'000};
  BenchSystem system({"mapping.workers=1", "survey.share=0"});
  const auto drive = RecordDrive(kBuilding, 1, 0.2, system.directory() / "drive");
  if (!drive.ok()) throw std::runtime_error(drive.status().ToString());
  nlohmann::json document = {{"benchmark", "growth"}};
  for (const int maps : sizes) {
    AddSites(system, 1, maps);
    std::cerr << maps << " maps\n";
    document["by_maps"].push_back(
        {{"maps", maps}, {"times", MeasureSite(system, fmt::format("size-{}-0", maps), maps, *drive, counts)}});
  }
  if (!all) return document;
  BenchSystem many({"mapping.workers=1", "survey.share=0"});
  constexpr int kMaps = 100;
  for (const int sites : {1, 100, 1'000}) {
    // Sites of one size more than before have another name each.
    AddSites(many, sites, kMaps + sites % 7);
    std::cerr << sites << " more sites\n";
    const std::string site = fmt::format("size-{}-{}", kMaps + sites % 7, sites - 1);
    document["by_sites"].push_back(
        {{"sites_added", sites}, {"times", MeasureSite(many, site, kMaps + sites % 7, *drive, counts)}});
  }
  return document;
}

}  // namespace
}  // namespace enfilade::bench

int main(int argc, char** argv) {
  try {
    const std::vector<std::string> arguments(argv + 1, argv + argc);
    bool quick = false;
    std::vector<int> sizes;
    for (const std::string& argument : arguments) {
      if (argument == "--quick") {
        quick = true;
      } else {
        sizes.push_back(std::stoi(argument));
      }
    }
    std::cout << enfilade::bench::Run(quick, std::move(sizes)).dump(2) << '\n';
  } catch (const std::exception& failure) {
    std::cerr << "bench_growth: " << failure.what() << '\n';
    return 1;
  }
}
