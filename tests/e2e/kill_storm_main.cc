// SPDX-License-Identifier: Apache-2.0
// Uploads one drive after the other while server, robot and database are killed (kill -9) at random moments, until
// there have been as many kills as asked for. After each drive every record sent must be stored once, with the same
// content, and the drive must be mapped. Fails at the first that is not.
//   kill_storm [--kills 1000] [--minutes 0] [--seed 1] [--laps 6] [--json FILE]
#include <chrono>
#include <fstream>
#include <iostream>
#include <random>
#include <stdexcept>

#include "CLI/CLI.hpp"
#include "enfilade/v1/site_service.grpc.pb.h"
#include "fmt/format.h"
#include "nlohmann/json.hpp"
#include "tests/e2e/kill_storm.h"

namespace enfilade::testing {
namespace {

struct StormOptions {
  int kills = 1000;
  double minutes = 0.0;  // after which no new drive begins; 0: no limit
  std::uint64_t seed = 1;
  int laps = 6;
  std::string json;
};

constexpr int kKillsPerDrive = 40;

struct StormReport {
  int drives = 0;
  std::int64_t records = 0;  // of all drives
  StormCounts counts;
  StoredRecords stored;
  std::string failure;
};

// In the background, while the next drive is uploaded.
void DeleteSite(WholeSystem& system, const std::string& site) {
  v1::DeleteSiteRequest request;
  request.set_name("sites/" + site);
  request.set_force(true);
  const auto deleted = system.server().Connect().Call(&v1::SiteService::Stub::DeleteSite, request);
  if (!deleted.ok()) throw std::runtime_error(std::string(deleted.status().message()));
}

void Drive(WholeSystem& system, const std::vector<std::string>& sent, int kills, std::mt19937_64& random,
           StormReport& report) {
  const Replay replay{.site = fmt::format("storm-{}", report.drives), .rate = "1.5"};
  system.CreateSite(replay.site);
  KillStorm storm(system, replay, static_cast<std::int64_t>(sent.size()), random);
  auto victims = VictimsInRandomOrder(kills, random);
  victims.resize(static_cast<std::size_t>(kills));
  report.counts += storm.Run(victims);
  storm.Finish();
  const StoredRecords stored = CompareStored(system, replay, sent);
  ++report.drives;
  report.records += static_cast<std::int64_t>(sent.size());
  report.stored.lost += stored.lost;
  report.stored.doubled += stored.doubled;
  report.stored.changed += stored.changed;
  DeleteSite(system, replay.site);
}

StormReport RunStorm(const StormOptions& options) {
  const auto started = std::chrono::steady_clock::now();
  std::mt19937_64 random(options.seed);
  StormReport report;
  try {
    WholeSystem system(Cluster::Durability::kDurable, {"mapping.lease_s=1", "mapping.checkpoint_interval_s=0.2",
                                                       "mapping.revision_interval_s=1", "listen.grace_s=2"});
    system.RecordDrive(options.laps);
    const std::vector<std::string> sent = RecordsOfLog(system.directory() / "drive.jsonl");
    while (report.counts.total() < options.kills && report.stored.intact()) {
      const std::chrono::duration<double, std::ratio<60>> elapsed = std::chrono::steady_clock::now() - started;
      if (options.minutes > 0.0 && elapsed.count() >= options.minutes) break;
      Drive(system, sent, std::min(kKillsPerDrive, options.kills - report.counts.total()), random, report);
      std::cout << fmt::format("{} kills, {} drives, {} records, {:.1f} min", report.counts.total(), report.drives,
                               report.records, elapsed.count())
                << std::endl;
    }
  } catch (const std::exception& error) {
    report.failure = error.what();
  }
  return report;
}

nlohmann::json ToJson(const StormOptions& options, const StormReport& report) {
  nlohmann::json json = {{"seed", options.seed},
                         {"kills", report.counts.total()},
                         {"kills_amid_mapping", report.counts.amid_mapping},
                         {"drives", report.drives},
                         {"records", report.records},
                         {"lost", report.stored.lost},
                         {"doubled", report.stored.doubled},
                         {"changed", report.stored.changed},
                         {"failure", report.failure}};
  for (std::size_t i = 0; i < kVictimNames.size(); ++i) json["kills_of"][kVictimNames[i]] = report.counts.kills[i];
  return json;
}

}  // namespace
}  // namespace enfilade::testing

int main(int argc, char** argv) {
  using namespace enfilade::testing;
  StormOptions options;
  CLI::App app("Kills server, robot and database while drives are uploaded");
  app.add_option("--kills", options.kills, "how many");
  app.add_option("--minutes", options.minutes, "begin no new drive after that; 0: no limit");
  app.add_option("--seed", options.seed, "of the order and the moments");
  app.add_option("--laps", options.laps, "of each drive");
  app.add_option("--json", options.json, "write the result to this file");
  CLI11_PARSE(app, argc, argv);

  const StormReport report = RunStorm(options);
  const nlohmann::json json = ToJson(options, report);
  if (!options.json.empty()) std::ofstream(options.json) << json.dump(1) << "\n";
  if (!report.failure.empty()) std::cout << "FAILED: " << report.failure << "\n";
  std::cout << fmt::format(
                   "kills: {} ({} of the server, {} of the robot, {} of the database, {} of its backends) in {} "
                   "drives of {} records: {} lost, {} doubled, {} changed",
                   report.counts.total(), report.counts.kills[0], report.counts.kills[1], report.counts.kills[2],
                   report.counts.kills[3], report.drives, report.records, report.stored.lost, report.stored.doubled,
                   report.stored.changed)
            << std::endl;
  return report.failure.empty() && report.stored.intact() ? 0 : 1;
}
