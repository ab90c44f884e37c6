// SPDX-License-Identifier: Apache-2.0
// Prints JSON: how one server serves a fleet that drives in real time (docs/benchmarks.md).
#include <algorithm>
#include <cmath>
#include <fstream>
#include <future>
#include <iostream>
#include <map>
#include <stdexcept>

#include "CLI/CLI.hpp"
#include "enfilade/v1/site_service.grpc.pb.h"
#include "fmt/format.h"
#include "nlohmann/json.hpp"
#include "tests/bench/fleet/fleet_readers.h"
#include "tests/bench/fleet/fleet_robot.h"
#include "tests/bench/fleet/recorded_drive.h"
#include "tests/bench/fleet/resource_samples.h"
#include "tests/bench/support/load_generator.h"
#include "tests/support/cluster.h"
#include "tests/support/command.h"
#include "tests/support/server_process.h"
#include "tests/support/test_data.h"

namespace enfilade::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kBatchSeconds = 0.2;
constexpr double kMinute = 60.0;
constexpr std::size_t kToldTables = 12;  // told of, the largest
constexpr auto kDrainPoll = std::chrono::seconds(1);

struct FleetOptions {
  int robots = 200;
  int sites = 20;
  double seconds = 600.0;
  int watchers = 20;
  int exporters = 2;
  int buildings = 4;
  int drives = 2;  // recorded in each building
  std::uint64_t first_seed = 9101;
  double drain_s = 300.0;
  double sample_s = 5.0;
  int retention_s = 0;  // 0: sites keep all
  std::vector<std::string> settings;
  std::string plot;
};

FleetOptions ParseOptions(int argc, char** argv) {
  FleetOptions options;
  CLI::App app("One server and a fleet that drives in real time: acknowledgements, readers, memory, mapping's backlog");
  app.add_option("--robots", options.robots)->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--sites", options.sites)->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--seconds", options.seconds)->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--watchers", options.watchers)->check(CLI::NonNegativeNumber)->capture_default_str();
  app.add_option("--exporters", options.exporters)->check(CLI::NonNegativeNumber)->capture_default_str();
  app.add_option("--buildings", options.buildings, "Different buildings; sites share them")->capture_default_str();
  app.add_option("--drives", options.drives, "Different drives through a building")->capture_default_str();
  app.add_option("--first-seed", options.first_seed, "Of the buildings")->capture_default_str();
  app.add_option("--drain", options.drain_s, "How long to wait for mapping afterwards, s")->capture_default_str();
  app.add_option("--sample", options.sample_s, "Between two samples of memory and such, s")->capture_default_str();
  app.add_option("--retention", options.retention_s,
                 "Of sessions, revisions, history, unused blobs and what undoing needs, s; 0: all is kept")
      ->check(CLI::Range(60, 86'400) | CLI::IsMember({0}))
      ->capture_default_str();
  app.add_option("--setting", options.settings, "Of the server, KEY=VALUE");
  app.add_option("--plot", options.plot, "Draw the samples over time into this SVG file");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    std::exit(app.exit(error));
  }
  return options;
}

template <typename T>
T Must(absl::StatusOr<T> value) {
  if (!value.ok()) throw std::runtime_error(value.status().ToString());
  return *std::move(value);
}

void SetRetention(v1::Site& site, int seconds) {
  constexpr int kRevisions = 3;
  for (google::protobuf::Duration* const retention :
       {site.mutable_raw_retention(), site.mutable_session_retention(), site.mutable_history_retention(),
        site.mutable_audit_retention(), site.mutable_revision_retention()->mutable_age()}) {
    retention->set_seconds(seconds);
  }
  site.mutable_revision_retention()->set_newest(kRevisions);
}

// Of the server: what its operator sets so that retentions of seconds are kept.
std::vector<std::string> SettingsOf(const FleetOptions& options) {
  std::vector<std::string> settings;
  if (options.retention_s > 0) {
    settings = {fmt::format("retention.interval_s={}", options.retention_s / 10.0),
                fmt::format("retention.unused_blob_s={}", options.retention_s),
                fmt::format("retention.deleted_session_s={}", options.retention_s),
                fmt::format("retention.undo_s={}", options.retention_s)};
  }
  settings.insert(settings.end(), options.settings.begin(), options.settings.end());
  return settings;
}

std::vector<SiteId> CreateSites(const client::Connection& connection, const FleetOptions& options) {
  std::vector<SiteId> sites;
  for (int i = 0; i < options.sites; ++i) {
    v1::CreateSiteRequest request;
    request.set_site_id(fmt::format("site-{}", i));
    request.mutable_site()->set_display_name(fmt::format("Site {}", i));
    if (options.retention_s > 0) SetRetention(*request.mutable_site(), options.retention_s);
    Must(connection.Call(&v1::SiteService::Stub::CreateSite, request));
    sites.emplace_back(request.site_id());
  }
  return sites;
}

// Drives of building 0, then of building 1, ...
std::vector<RecordedDrive> RecordDrives(const FleetOptions& options, const std::filesystem::path& folder) {
  std::vector<RecordedDrive> drives;
  for (int building = 0; building < options.buildings; ++building) {
    for (int drive = 0; drive < options.drives; ++drive) {
      drives.push_back(Must(RecordDrive(options.first_seed + static_cast<std::uint64_t>(building),
                                        static_cast<std::uint64_t>(drive) + 1, kBatchSeconds, folder)));
      std::cerr << fmt::format("building {}: {} scans in {} sessions\n", building, drives.back().scans,
                               drives.back().sessions.size());
    }
  }
  return drives;
}

// The robots, site by site: each site has one building. The first robot of a site starts first; the others follow when
// there is a map.
std::vector<FleetRobotResult> Drive(const FleetOptions& options, const std::string& address,
                                    const std::vector<SiteId>& sites, const std::vector<RecordedDrive>& drives,
                                    const FleetClock& clock) {
  constexpr double kFollow = 20.0;  // s
  std::vector<std::future<FleetRobotResult>> running;
  for (int i = 0; i < options.robots; ++i) {
    const int site = i % options.sites;
    const int place = i / options.sites;  // of the site's robots
    const int building = site % options.buildings;
    const RecordedDrive& drive = drives[static_cast<std::size_t>(building * options.drives + place % options.drives)];
    FleetRobotOptions robot;
    robot.site = sites[static_cast<std::size_t>(site)];
    robot.robot = RobotId(fmt::format("robot-{}", place));
    robot.first_of_site = place == 0;
    robot.start_s = place * kFollow + site * kFollow / options.sites;
    running.push_back(std::async(std::launch::async, [=, &drive, &clock] {
      const client::Connection connection(address, std::chrono::seconds(60));
      return DriveUntilEnd(connection, drive, robot, clock);
    }));
  }
  std::vector<FleetRobotResult> results;
  for (auto& robot : running) results.push_back(robot.get());
  return results;
}

nlohmann::json Summary(std::vector<double> values) {
  if (values.empty()) return {{"count", 0}};
  const std::size_t count = values.size();
  return {{"count", count},
          {"p50_ms", Percentile(values, 0.5)},
          {"p99_ms", Percentile(values, 0.99)},
          {"max_ms", Percentile(values, 1.0)}};
}

nlohmann::json SummaryOf(const std::vector<FleetRobotResult>& robots) {
  std::vector<double> all;
  std::map<int, std::vector<double>> by_minute;
  std::map<std::string, int> errors;
  std::int64_t records = 0, scans = 0, poses = 0, sessions = 0;
  for (const FleetRobotResult& robot : robots) {
    for (const Acknowledged& one : robot.acknowledged) {
      all.push_back(one.latency_ms);
      by_minute[static_cast<int>(one.at / kMinute)].push_back(one.latency_ms);
    }
    records += robot.records;
    scans += robot.scans;
    poses += robot.pose_reports;
    sessions += robot.sessions;
    if (!robot.status.ok()) ++errors[robot.status.ToString()];
  }
  nlohmann::json summary = {{"records", records},        {"scans", scans},
                            {"pose_reports", poses},     {"sessions", sessions},
                            {"robots_ended_by", errors}, {"acknowledgements", Summary(std::move(all))}};
  for (auto& [minute, values] : by_minute) {
    nlohmann::json one = Summary(std::move(values));
    one["minute"] = minute;
    summary["by_minute"].push_back(std::move(one));
  }
  return summary;
}

// Waits until everything is mapped; seconds, or nothing after `limit`.
nlohmann::json AwaitDrain(ResourceSampler& sampler, double limit) {
  const Clock::time_point begin = Clock::now();
  while (true) {
    const double waited = std::chrono::duration<double>(Clock::now() - begin).count();
    if (sampler.Take().backlog_records == 0) return waited;
    if (waited > limit) return nullptr;
    std::this_thread::sleep_for(kDrainPoll);
  }
}

nlohmann::json Run(const FleetOptions& options) {
  testing::TemporaryDirectory directory;
  const std::vector<RecordedDrive> drives = RecordDrives(options, directory.path() / "drives");
  testing::Cluster cluster(testing::Cluster::Durability::kDurable);
  const auto migrate = testing::RunCommand({testing::ProjectFile("deploy/database/migrate"), "up", cluster.url()});
  if (migrate.exit_code != 0) throw std::runtime_error("the migrations failed:\n" + migrate.output);
  testing::ServerProcess server(directory.path(), "server", cluster.url(), SettingsOf(options));
  server.StartAndWait();
  const std::vector<SiteId> sites = CreateSites(server.Connect(), options);

  ResourceSampler sampler(server.process().pid(), cluster.pid(), cluster.url(),
                          std::chrono::duration<double>(options.sample_s));
  FleetReaders readers(server.Connect(), sites, options.watchers, options.exporters, directory.path());
  const Clock::time_point start = Clock::now();
  const FleetClock clock{
      start, start + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(options.seconds))};
  const std::vector<FleetRobotResult> robots = Drive(options, server.address(), sites, drives, clock);
  FleetReaders::Counts read = readers.Stop();
  const std::vector<ResourceSample> samples = sampler.Stop();

  nlohmann::json document = {{"benchmark", "fleet"},
                             {"robots", options.robots},
                             {"sites", options.sites},
                             {"seconds", options.seconds},
                             {"retention_s", options.retention_s},
                             {"batch_s", kBatchSeconds},
                             {"fleet", SummaryOf(robots)},
                             {"get_site", Summary(std::move(read.get_site_ms))},
                             {"failed_get_site", read.failed_calls},
                             {"pose_messages", read.pose_messages},
                             {"watches_ended", read.errors},
                             {"exports", read.exports},
                             {"exported_mib", static_cast<double>(read.exported_bytes) / (1 << 20)},
                             {"failed_exports", read.failed_exports}};
  for (const ResourceSample& sample : samples) document["samples"].push_back(ToJson(sample));
  document["drained_after_s"] = AwaitDrain(sampler, options.drain_s);
  document["tables"] = TablesToJson(samples, kToldTables);
  if (!options.plot.empty()) std::ofstream(options.plot) << DrawSamples(samples);
  return document;
}

}  // namespace
}  // namespace enfilade::bench

int main(int argc, char** argv) {
  try {
    std::cout << enfilade::bench::Run(enfilade::bench::ParseOptions(argc, argv)).dump(2) << '\n';
  } catch (const std::exception& failure) {
    std::cerr << "bench_fleet: " << failure.what() << '\n';
    return 1;
  }
}
