// SPDX-License-Identifier: Apache-2.0
// Automatic mapping of simulated campuses and of recorded logs by a private server and database, each run on a site of
// its own, compared with the truth. docs/benchmarks.md explains the columns.
#include <algorithm>
#include <fstream>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "fmt/format.h"
#include "fmt/ranges.h"
#include "tests/e2e/campus/campus_run.h"
#include "tests/e2e/campus/report.h"

namespace enfilade::testing {
namespace {

struct Options {
  std::vector<std::string> campuses;
  int seeds = 1;
  CampusRun run;
  std::string delay;
  std::vector<std::string> logs;
  LogRun log;
  PicturedRooms rooms;  // of the logs
  std::vector<double> rooms_at;
  std::optional<double> range_max;  // m, of the logs
  std::string report;
  bool verdicts = false;
  double require = 0.95;
  std::string command;                // line
  std::vector<std::string> settings;  // of the server
};

// random:8001-8050 is fifty campuses, suites:1-9 nine; everything else is one.
std::vector<std::string> Expand(const std::string& campus) {
  const std::size_t dash = campus.rfind('-');
  const std::size_t seeds = campus.find(':') + 1;
  const std::string kind = campus.substr(0, seeds);
  if ((kind != "random:" && kind != "suites:" && kind != "halls:") || dash == std::string::npos) return {campus};
  const auto number = [&](std::size_t begin, std::size_t end) {
    const std::string text = campus.substr(begin, end - begin);
    if (text.empty() || text.size() > 9 || text.find_first_not_of("0123456789") != std::string::npos) {
      throw CLI::ValidationError("--campus", fmt::format("{0}: expected {1}SEED or {1}FIRST-LAST", campus, kind));
    }
    return std::stoull(text);
  };
  const std::uint64_t last = number(dash + 1, campus.size());
  std::vector<std::string> campuses;
  for (std::uint64_t seed = number(seeds, dash); seed <= last; ++seed) campuses.push_back(kind + std::to_string(seed));
  if (campuses.empty()) throw CLI::ValidationError("--campus", campus + ": the last is before the first");
  return campuses;
}

void AddOptions(CLI::App& app, Options& options) {
  app.add_option("--campus", options.campuses,
                 "Campuses, comma-separated: figure1, lookalike, levels, random:SEED, random:FIRST-LAST, suites:SEED, "
                 "suites:FIRST-LAST, halls:SEED, halls:FIRST-LAST, a file (YAML), NAME.building.yaml of Open-RMF")
      ->delimiter(',');
  app.add_option("--seeds", options.seeds, "Seeds of noise, each a run of its own")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--first", options.run.seed, "The first seed of noise")->capture_default_str();
  app.add_option("--robots", options.run.robots, "The robots that drive, comma-separated (default: the campus's first)")
      ->delimiter(',');
  app.add_option("--laps", options.run.laps, "Rounds of each robot's route (default: the campus's)")
      ->check(CLI::PositiveNumber);
  app.add_option("--delay", options.delay,
                 "When the next robot starts: so many seconds after the one before, or `done`: when that one is done "
                 "(default: at once)");
  app.add_flag("--unknown-starts", options.run.unknown_starts,
               "The other robots do not know where they start: each begins a map of its own");
  app.add_option("--image-hz", options.run.image_hz, "Rate of images, Hz (0: none, which is much faster)");
  app.add_option("--cloud-hz", options.run.cloud_hz, "Rate of point clouds, Hz (0: none)");
  app.add_option("--fov", options.run.field_of_view_deg,
                 "The scanner's field of view, degrees (logs: if they do not state it)");
  app.add_option("--log", options.logs,
                 "Recorded logs, comma-separated: each mapped by `enfilade robot`, and by `enfilade slam` as one map")
      ->delimiter(',');
  app.add_option("--relations", options.log.relations, "Logs: measure the errors by these relations between poses")
      ->check(CLI::ExistingFile);
  app.add_option("--reference", options.log.reference, "Logs: measure the errors against this trajectory, `t x y yaw`")
      ->check(CLI::ExistingFile);
  app.add_option("--rooms", options.rooms.picture,
                 "Logs: compare the maps with the rooms of this picture, PNG, in which each has a colour of its own")
      ->check(CLI::ExistingFile);
  app.add_option("--rooms-at", options.rooms_at,
                 "X,Y,YAW,M: where the picture's lower left corner is in the map of `enfilade slam` (m, m, deg), and "
                 "how many metres a pixel has")
      ->delimiter(',')
      ->expected(4)
      ->needs("--rooms");
  app.get_option("--rooms")->needs("--rooms-at");
  app.add_flag("--simulate-odometry", options.log.simulate_odometry,
               "Logs: their odometry is a corrected path. It becomes the reference, and the robot gets a copy with "
               "errors (5 %, 3 deg/m), for each seed another");
  app.add_option("--odometry-ahead", options.log.odometry_ahead,
                 "Logs: their odometry runs so many samples ahead of the scans, and the robot gets it in time")
      ->check(CLI::NonNegativeNumber)
      ->excludes("--simulate-odometry");
  app.add_option("--range-max", options.range_max, "Logs: ranges of this or more mean \"no return\", m");
  app.add_option("--setting", options.settings, "A setting of the server, KEY=VALUE (may be repeated)");
  app.add_option("--report", options.report, "Write all figures into this file as JSON, again after every run");
  app.add_flag("--verdicts", options.verdicts, "Print every verdict on a door with its reason");
  app.add_option("--keep", options.run.keep,
                 "Keep the truth, the robots' output and the graph in a folder per run here");
  app.add_option("--require", options.require, "The share of runs that must be exact for exit code 0")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  app.footer(
      "Exit code: 0; 1 if fewer runs are exact than required, a robot was placed falsely, a log's graph is in pieces, "
      "or "
      "a run failed; 2 for bad options.\n"
      "Examples:\n"
      "  campus_seeds --campus figure1 --seeds 20 --robots r1,r2\n"
      "  campus_seeds --campus random:8001-8050 --image-hz 0 --cloud-hz 0 --require 0.8 --report runs.json\n"
      "  campus_seeds --campus random:8001 --robots robot,robot2 --delay done --keep out\n"
      "  campus_seeds --log intel.clf.gz --relations intel.relations --keep out\n"
      "  campus_seeds --log intel.clf.gz --rooms rooms.png --rooms-at=-21.55,-34.76,2.28,0.05027\n"
      "  campus_seeds --log freiburg-101-corrected.log.gz --simulate-odometry --seeds 3");
}

void ApplyDelay(Options& options) {
  if (options.delay.empty()) return;
  options.run.start = options.delay == "done" ? Start::kAfterwards : Start::kDelayed;
  if (options.delay == "done") return;
  std::size_t end = 0;
  try {
    options.run.delay_s = std::stod(options.delay, &end);
  } catch (const std::exception&) {
  }
  if (end != options.delay.size() || !(options.run.delay_s >= 0.0)) {
    throw CLI::ValidationError("--delay", options.delay + ": expected seconds or `done`");
  }
}

void ApplyLogOptions(Options& options) {
  options.log.keep = options.run.keep;
  const auto add = [&](const char* option, const std::optional<double>& value) {
    if (value) options.log.reading.insert(options.log.reading.end(), {option, fmt::format("{}", *value)});
  };
  add("--fov", options.run.field_of_view_deg);
  add("--range-max", options.range_max);
  if (options.rooms_at.empty()) return;
  options.rooms.T_map_picture = {options.rooms_at[0], options.rooms_at[1], options.rooms_at[2] * kDegree};
  options.rooms.resolution = options.rooms_at[3];
  if (!(options.rooms.resolution > 0.0)) {
    throw CLI::ValidationError("--rooms-at", "a pixel's size must be more than 0 m");
  }
  options.log.rooms = options.rooms;
}

class Experiment {
 public:
  explicit Experiment(const Options& options) : options_(options) {}

  int Run() {
    WholeSystem system(options_.settings);
    if (!options_.logs.empty()) RunLogs(system);
    if (!options_.campuses.empty()) RunCampuses(system);
    const bool enough = totals_.exact_share() >= options_.require - 1e-9 || options_.campuses.empty();
    return enough && failed_ == 0 && pieces_ == 0 && totals_.sums.false_placements == 0 ? 0 : 1;
  }

 private:
  void RunCampuses(WholeSystem& system) {
    std::cout << CampusHeader() << std::endl;
    for (const std::string& campus : options_.campuses) {
      CampusRun run = options_.run;
      run.campus = campus;
      for (int i = 0; i < options_.seeds; ++i, ++run.seed) RunOne(system, run);
    }
    std::cout << Summary(totals_) << std::endl;
  }

  void RunLogs(WholeSystem& system) {
    std::cout << LogHeader() << std::endl;
    for (const std::string& log : options_.logs) {
      LogRun run = options_.log;
      run.log = log;
      run.seed = options_.run.seed;
      for (int i = 0; i < options_.seeds; ++i, ++run.seed) RunOne(system, run);
    }
  }

  void RunOne(WholeSystem& system, const LogRun& run) {
    try {
      const LogResult result = RunLog(system, run);
      pieces_ += result.components - 1;
      std::cout << LogLine(run, result) << std::endl;
      PrintVerdicts(result.verdicts);
      runs_.push_back(ToJson(run, result));
    } catch (const std::exception& error) {
      Fail({{"log", run.log.string()}, {"seed", run.seed}}, run.log.filename().string(), error);
    }
    WriteReport();
  }

  void RunOne(WholeSystem& system, const CampusRun& run) {
    try {
      const CampusResult result = RunCampus(system, run);
      totals_.Add(result);
      std::cout << CampusLine(run, result) << std::endl;
      PrintVerdicts(result.verdicts);
      runs_.push_back(ToJson(run, result));
    } catch (const std::exception& error) {
      ++totals_.runs;
      ++totals_.failed;
      Fail({{"campus", run.campus}, {"seed", run.seed}}, run.campus, error);
    }
    WriteReport();
  }

  void PrintVerdicts(const std::vector<std::string>& verdicts) const {
    if (!options_.verdicts) return;
    for (const std::string& verdict : verdicts) std::cout << "    " << verdict << std::endl;
  }

  void Fail(nlohmann::json run, const std::string& name, const std::exception& error) {
    ++failed_;
    std::cout << fmt::format("{:<28} FAILED {}", name, error.what()) << std::endl;
    run["failed"] = error.what();
    runs_.push_back(std::move(run));
  }

  void WriteReport() const {
    if (options_.report.empty()) return;
    nlohmann::json document = {{"command", options_.command}, {"runs", runs_}};
    if (totals_.runs > 0) document["totals"] = ToJson(totals_);
    std::ofstream(options_.report) << document.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
  }

  const Options& options_;
  CampusTotals totals_;
  int failed_ = 0;  // runs
  int pieces_ = 0;  // of the logs' graphs, more than one each
  nlohmann::json runs_ = nlohmann::json::array();
};

int Main(int argc, char** argv) {
  CLI::App app("Map simulated campuses automatically and compare the maps with the truth (docs/benchmarks.md)",
               "campus_seeds");
  Options options;
  AddOptions(app, options);
  options.command = fmt::format("{}", fmt::join(argv, argv + argc, " "));
  try {
    app.parse(argc, argv);
    ApplyDelay(options);
    if (options.campuses.empty() && options.logs.empty()) options.campuses = {"figure1"};
    ApplyLogOptions(options);
    std::vector<std::string> expanded;
    for (const std::string& campus : options.campuses) {
      const std::vector<std::string> some = Expand(campus);
      expanded.insert(expanded.end(), some.begin(), some.end());
    }
    options.campuses = expanded;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    return Experiment(options).Run();
  } catch (const std::exception& error) {
    std::cerr << "campus_seeds: " << error.what() << '\n';
    return 2;
  }
}

}  // namespace
}  // namespace enfilade::testing

int main(int argc, char** argv) { return enfilade::testing::Main(argc, argv); }
