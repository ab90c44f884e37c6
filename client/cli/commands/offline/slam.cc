// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/commands/offline/slam_files.h"
#include "client/cli/entry_options.h"
#include "client/cli/log_mapping.h"
#include "client/cli/log_options.h"
#include "client/cli/map_file_reader.h"
#include "client/cli/output.h"
#include "client/sources/log_reader.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/grid/files/map_files.h"
#include "core/grid/overlay.h"
#include "core/slam/mapper/log_mapper.h"
#include "core/slam/slam_options_yaml.h"
#include "io/file.h"

namespace enfilade::cli {
namespace {

using Clock = std::chrono::steady_clock;

struct SlamCommandOptions {
  std::string log;
  std::string directory;
  bool plot = false;
  sources::LogOptions reading;
  bool print_options = false;
  std::string options_file;
  std::string existing_map;
  EntryOptions entry;
};

struct SlamRun {
  slam::SlamMap map;
  grid::OccupancyGrid grid;
  slam::LogMapperCounts counts;
  std::int64_t scans = 0;
  double seconds = 0.0;  // of mapping, without reading the log
};

absl::StatusOr<slam::SlamOptions> ReadSlamOptions(const std::string& path) {
  if (path.empty()) return slam::SlamOptions{};
  ENFILADE_ASSIGN_OR_RETURN(const std::string text, io::ReadFile(path));
  return slam::ParseSlamOptions(text, path);
}

// The map of --on, if given.
absl::StatusOr<std::optional<slam::ExistingMap>> LoadExistingMap(const SlamCommandOptions& options,
                                                                 const slam::SlamOptions& slam) {
  ENFILADE_ASSIGN_OR_RETURN(const std::optional<PoseWithCovariance> entry, EntryOf(options.entry));
  if (options.existing_map.empty() != !entry) {
    return InvalidArgument(
        "slam: --on and --at go together: the existing map, and the pose in it where the log starts");
  }
  if (!entry) return std::nullopt;
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<grid::MapFile> files, ReadMapFiles(options.existing_map));
  ENFILADE_ASSIGN_OR_RETURN(const grid::ImportedMap imported, grid::ImportFiles(files, grid::MapDialect::kNav2));
  const absl::StatusOr<grid::OccupancyGrid> grid =
      grid::ResampleToLattice(grid::ToOccupancyGrid(imported.raster), slam.resolution);
  if (!grid.ok()) return WithContext(grid.status(), options.existing_map);
  return slam::ExistingMap{*grid, {*entry, std::nullopt}};
}

absl::StatusOr<SlamRun> MapLog(const Globals& globals, const SlamCommandOptions& options,
                               const slam::SlamOptions& slam) {
  ENFILADE_ASSIGN_OR_RETURN(sources::LogReader reader, sources::LogReader::Open(options.log, options.reading));
  ENFILADE_ASSIGN_OR_RETURN(const std::optional<slam::ExistingMap> existing_map, LoadExistingMap(options, slam));
  slam::LogMapper mapper = existing_map ? slam::LogMapper(sensor::ScanPairingOptions{}, slam, *existing_map)
                                        : slam::LogMapper(sensor::ScanPairingOptions{}, slam);
  SlamRun run;
  ENFILADE_ASSIGN_OR_RETURN(Clock::duration spent, MapToEnd(globals, reader, mapper));
  const Clock::time_point begin = Clock::now();
  run.grid = mapper.RenderGrid();
  if (existing_map) {
    ENFILADE_ASSIGN_OR_RETURN(run.grid, grid::Overlay(existing_map->grid, run.grid));
  }
  run.map.Apply(mapper.TakeDelta());
  spent += Clock::now() - begin;
  run.counts = mapper.counts();
  run.scans = reader.counts().scans;
  run.seconds = std::chrono::duration<double>(spent).count();
  return run;
}

void PrintReport(const Globals& globals, const SlamRun& run) {
  std::int64_t accepted = 0;
  for (const auto& [id, closure] : run.map.loop_closures)
    accepted += closure.state == slam::LoopClosureState::kAccepted;
  const auto rejected = static_cast<std::int64_t>(run.map.loop_closures.size()) - accepted;
  const double rate = run.seconds > 0.0 ? static_cast<double>(run.scans) / run.seconds : 0.0;
  if (globals.json) {
    PrintJson(std::cout, {{"scans", run.scans},
                          {"used", run.counts.used},
                          {"keyframes", run.counts.keyframes},
                          {"lost", run.counts.lost},
                          {"without_odometry", run.counts.pairing.unpaired},
                          {"dropped", run.counts.pairing.time_reversed},
                          {"submaps", run.map.submaps.size()},
                          {"closures_accepted", accepted},
                          {"closures_rejected", rejected},
                          {"seconds", run.seconds},
                          {"scans_per_second", rate}});
    return;
  }
  std::cout << fmt::format("{} scans ({} used, {} keyframes, {} lost) in {}: {:.0f} scans/s\n", run.scans,
                           run.counts.used, run.counts.keyframes, run.counts.lost, FormatSeconds(run.seconds), rate)
            << fmt::format("{} submaps, {} loops closed, {} attempts rejected\n", run.map.submaps.size(), accepted,
                           rejected);
  if (run.counts.pairing.time_reversed > 0) {
    std::cout << fmt::format("{} records with a time before their predecessor's were dropped\n",
                             run.counts.pairing.time_reversed);
  }
}

absl::Status RunSlam(const Globals& globals, const SlamCommandOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const slam::SlamOptions slam, ReadSlamOptions(options.options_file));
  if (options.print_options) {
    std::cout << slam::FormatSlamOptions(slam);
    return absl::OkStatus();
  }
  if (options.log.empty()) return InvalidArgument("slam: LOG is missing (see enfilade slam --help)");
  if (options.plot && options.directory.empty()) return InvalidArgument("slam: --plot needs -o DIR");
  ENFILADE_ASSIGN_OR_RETURN(const SlamRun run, MapLog(globals, options, slam));
  if (!options.directory.empty()) {
    ENFILADE_RETURN_IF_ERROR(WriteSlamFiles(options.directory, run.map, run.grid, options.plot));
  }
  PrintReport(globals, run);
  return absl::OkStatus();
}

}  // namespace

void AddSlam(CLI::App& app, const Globals& globals) {
  auto options = std::make_shared<SlamCommandOptions>();
  CLI::App* command = AddCommand(app, "slam", "Map a recorded log locally, without a server",
                                 [&globals, options] { return RunSlam(globals, *options); });
  command->add_option("LOG", options->log, "The log (docs/logs.md lists the formats)");
  command->add_option("-o,--output", options->directory,
                      "The folder for trajectory.txt, map.pgm, map.yaml, map.png and closures.json");
  command->add_option("--on", options->existing_map, "An existing map (YAML or JSON) to extend: needs --at");
  AddEntryOptions(*command, options->entry);
  AddNoOdometry(*command, options->reading);
  AddLogOptions(*command, options->reading);
  command->add_flag("--plot", options->plot, "Also write plot.png: the trajectory over the map");
  command->add_option("--options", options->options_file, "A YAML file with SLAM options (docs/slam.md)");
  command->add_flag("--print-options", options->print_options, "Print all SLAM options as YAML and exit");
  command->footer(
      "Examples:\n"
      "  enfilade slam drive.jsonl -o out --plot\n"
      "  enfilade slam next.jsonl --on out/map.yaml --at 3.2,-1,1.57 -o both");
}

}  // namespace enfilade::cli
