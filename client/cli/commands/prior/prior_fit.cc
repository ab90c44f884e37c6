// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/commands/offline/slam_files.h"
#include "client/cli/commands/prior/plan_options.h"
#include "client/cli/commands/prior/prior_fit_files.h"
#include "client/cli/log_mapping.h"
#include "client/cli/log_options.h"
#include "client/cli/occupancy_map.h"
#include "client/cli/output.h"
#include "client/sources/log_reader.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/grid/files/map_files.h"
#include "core/prior/alignment/map_evidence.h"
#include "core/prior/fit/fit_plan.h"
#include "core/prior/products/products.h"
#include "core/prior/slam/map_with_plan.h"
#include "core/slam/mapper/log_mapper.h"
#include "fmt/format.h"
#include "io/file.h"
#include "perception/plan/read_plan.h"

namespace enfilade::cli {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kMostThreads = 64;

int DefaultThreads() { return std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, kMostThreads); }

struct PriorFitOptions {
  PlanOptions plan;
  std::vector<std::string> inputs;
  std::string directory;
  std::string pairs;
  std::string points;
  std::string mode{prior::NameOf(prior::FitMode::kFull)};
  bool automatic = false;
  bool correct_map = false;
  std::string trajectory;
  std::optional<double> resolution;
  int threads = DefaultThreads();
  sources::LogOptions reading;
};

bool IsMap(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  return extension == ".yaml" || extension == ".yml" || extension == ".json" || extension == ".png" ||
         extension == ".pgm";
}

absl::StatusOr<grid::OccupancyGrid> MapLog(const Globals& globals, const PriorFitOptions& options,
                                           const std::string& path) {
  ENFILADE_ASSIGN_OR_RETURN(sources::LogReader reader, sources::LogReader::Open(path, options.reading));
  slam::LogMapper mapper(sensor::ScanPairingOptions{}, slam::SlamOptions{});
  ENFILADE_RETURN_IF_ERROR(MapToEnd(globals, reader, mapper).status());
  return mapper.RenderGrid();
}

// The log's map, corrected by the plan, and with --trajectory the file.
absl::StatusOr<prior::MapWithPlan> MapWithPlan(const PriorFitOptions& options, const prior::PlanGraph& plan,
                                               const prior::FitOptions& fitting) {
  ENFILADE_ASSIGN_OR_RETURN(sources::LogReader reader,
                            sources::LogReader::Open(options.inputs.front(), options.reading));
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<sensor::PairedScan> scans, ReadScans(reader));
  ENFILADE_ASSIGN_OR_RETURN(prior::MapWithPlan mapped,
                            prior::MapLogWithPlan(plan, scans, fitting, slam::SlamOptions{}));
  if (!options.trajectory.empty()) {
    ENFILADE_RETURN_IF_ERROR(io::WriteFile(options.trajectory, TrajectoryText(mapped.mapped.map)));
  }
  return mapped;
}

absl::StatusOr<std::vector<grid::OccupancyGrid>> ReadInputs(const Globals& globals, const PriorFitOptions& options) {
  std::vector<grid::OccupancyGrid> maps;
  for (const std::string& path : options.inputs) {
    ENFILADE_ASSIGN_OR_RETURN(grid::OccupancyGrid map, IsMap(path) ? ReadOccupancyMap(path, options.resolution)
                                                                   : MapLog(globals, options, path));
    maps.push_back(std::move(map));
  }
  return maps;
}

// FitPlan knows maps by their numbers only: an error that is one input's own begins with its path.
absl::StatusOr<prior::PlanFit> FitInputs(const PriorFitOptions& options, const prior::PlanGraph& plan,
                                         const std::vector<grid::OccupancyGrid>& maps,
                                         const prior::FitOptions& fitting) {
  absl::StatusOr<prior::PlanFit> fit = prior::FitPlan(plan, maps, fitting);
  if (!absl::IsInvalidArgument(fit.status())) return fit;
  for (std::size_t i = 0; i < maps.size(); ++i) {
    if (prior::EvidenceOf(maps[i]).walls.empty()) return InvalidArgument("{}: no walls in it", options.inputs[i]);
  }
  return fit;
}

absl::StatusOr<prior::FitOptions> ToFitOptions(const PriorFitOptions& options) {
  prior::FitOptions fit;
  fit.mode = prior::FitModeFrom(options.mode).value();  // the command line has checked it
  fit.threads = options.threads;
  if (!options.pairs.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(fit.pairs, ReadPairs(options.pairs));
  }
  return fit;
}

absl::Status WriteAll(const std::filesystem::path& directory, const std::vector<grid::MapFile>& files) {
  for (const grid::MapFile& file : files) ENFILADE_RETURN_IF_ERROR(io::WriteFile(directory / file.name, file.bytes));
  return absl::OkStatus();
}

absl::Status WriteFiles(const PriorFitOptions& options, const prior::PlanGraph& plan, const prior::PlanFit& fit,
                        const std::vector<Eigen::Vector2d>& points) {
  const std::filesystem::path directory = options.directory;
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error) return InvalidArgument("{}: {}", options.directory, error.message());
  ENFILADE_RETURN_IF_ERROR(WriteAll(directory, prior::CorrectedFiles(plan, fit)));
  ENFILADE_ASSIGN_OR_RETURN(const auto planning, prior::PlanningFiles(plan, fit, grid::MapFileFormat::kPgm));
  ENFILADE_RETURN_IF_ERROR(WriteAll(directory, planning));
  ENFILADE_ASSIGN_OR_RETURN(const grid::MapFile picture, prior::PictureFile(plan, fit));
  ENFILADE_RETURN_IF_ERROR(WriteAll(directory, {picture}));
  if (options.points.empty()) return absl::OkStatus();
  return io::WriteFile(directory / "points.csv", WriteLocatedPoints(points, plan, *fit.corrected));
}

nlohmann::json InputReport(const std::string& input, const prior::FittedMap& map) {
  nlohmann::json report = {{"input", input}, {"accepted", map.alignment.accepted}, {"reason", map.alignment.reason}};
  if (map.T_first_map) report["T_first_input"] = {map.T_first_map->x, map.T_first_map->y, map.T_first_map->yaw};
  return report;
}

// `with_plan`: null without --correct-map. `seconds`: without mapping logs.
void PrintReport(const Globals& globals, const PriorFitOptions& options, const prior::PlanFit& fit,
                 const prior::MapWithPlan* with_plan, double seconds) {
  const prior::Alignment& alignment = fit.alignment;
  const prior::Agreement& agreement = fit.corrected ? fit.corrected->agreement() : alignment.agreement;
  const Eigen::Matrix2d& linear = alignment.T_map_sheet.linear;
  const Eigen::Vector2d& offset = alignment.T_map_sheet.offset;
  if (globals.json) {
    nlohmann::json report = {
        {"accepted", alignment.accepted},
        {"reason", alignment.reason},
        {"mode", options.mode},
        {"mirrored", alignment.T_map_sheet.mirrored()},
        {"model", prior::NameOf(alignment.model)},
        {"A_input_plan", {linear(0, 0), linear(0, 1), offset.x(), linear(1, 0), linear(1, 1), offset.y()}},
        {"explained", agreement.explained},
        {"contradicted", agreement.contradicted()},
        {"rival_ratio", alignment.rival_ratio},
        {"inputs", nlohmann::json::array()},
        {"seconds", seconds}};
    for (std::size_t i = 0; i < fit.maps.size(); ++i) {
      report["inputs"].push_back(InputReport(options.inputs[i], fit.maps[i]));
    }
    if (with_plan != nullptr) {
      report["map"] = {{"corrected", with_plan->corrected}, {"reason", with_plan->reason}};
    }
    return PrintJson(std::cout, report);
  }
  if (with_plan != nullptr) {
    std::cout << fmt::format("map {}: {}\n", with_plan->corrected ? "corrected" : "as without the plan",
                             with_plan->reason);
  }
  std::cout << fmt::format("{}: {}\n", alignment.accepted ? "accepted" : "refused", alignment.reason)
            << fmt::format(
                   "{}{}, {:.5g} m per unit of the plan; {:.0f} % of the map's walls explained, {:.0f} % of the "
                   "plan's known walls contradicted; {}\n",
                   alignment.T_map_sheet.mirrored() ? "mirrored, " : "", prior::NameOf(alignment.model),
                   alignment.T_map_sheet.scale(), 100 * agreement.explained, 100 * agreement.contradicted(),
                   FormatSeconds(seconds));
  for (std::size_t i = 1; i < fit.maps.size(); ++i) {
    std::cout << fmt::format("{}: {}{}\n", options.inputs[i], fit.maps[i].T_first_map ? "joined; " : "left out; ",
                             fit.maps[i].alignment.reason);
  }
}

absl::Status RunPriorFit(const Globals& globals, const PriorFitOptions& options) {
  if (!options.points.empty() && options.directory.empty()) return InvalidArgument("prior fit: --points needs -o DIR");
  if (options.correct_map && (options.inputs.size() != 1 || IsMap(options.inputs.front()))) {
    return InvalidArgument("prior fit: --correct-map needs one INPUT, a recorded log");
  }
  std::vector<Eigen::Vector2d> points;
  if (!options.points.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(points, ReadSheetPoints(options.points));
  }
  ENFILADE_ASSIGN_OR_RETURN(const perception::ReadPlanOptions reading, ToReadOptions(options.plan));
  ENFILADE_ASSIGN_OR_RETURN(const prior::PlanGraph plan, perception::ReadPlan(options.plan.path, reading));
  ENFILADE_ASSIGN_OR_RETURN(prior::FitOptions fitting, ToFitOptions(options));
  for (prior::ControlPair& pair : fitting.pairs) pair.point_sheet = prior::ToSheet(plan, pair.point_sheet);
  std::optional<prior::MapWithPlan> with_plan;
  std::vector<grid::OccupancyGrid> maps;
  if (options.correct_map) {
    ENFILADE_ASSIGN_OR_RETURN(with_plan, MapWithPlan(options, plan, fitting));
    maps.push_back(with_plan->mapped.grid);
  } else {
    ENFILADE_ASSIGN_OR_RETURN(maps, ReadInputs(globals, options));
  }
  const Clock::time_point begin = Clock::now();
  ENFILADE_ASSIGN_OR_RETURN(const prior::PlanFit fit, FitInputs(options, plan, maps, fitting));
  const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  if (fit.corrected && !options.directory.empty()) ENFILADE_RETURN_IF_ERROR(WriteFiles(options, plan, fit, points));
  PrintReport(globals, options, fit, with_plan ? &*with_plan : nullptr, seconds);
  return absl::OkStatus();
}

}  // namespace

void AddPriorFit(CLI::App& prior, const Globals& globals) {
  auto options = std::make_shared<PriorFitOptions>();
  CLI::App* command =
      AddCommand(prior, "fit", "Find where a floor plan lies in a map, and move its walls onto the map's",
                 [&globals, options] { return RunPriorFit(globals, *options); });
  AddPlanOptions(*command, options->plan);
  command
      ->add_option("INPUT", options->inputs,
                   "Maps (YAML, JSON, PNG or PGM) and recorded logs, which are mapped first. Several are joined by the "
                   "plan, in the frame of the first")
      ->required();
  command->add_option(
      "-o,--output", options->directory,
      "Write the corrected walls, the planning map and fit.png into this folder, and points.csv with --points");
  CLI::Option* pairs = command->add_option(
      "--pairs", options->pairs, "Points that are known in both: lines of plan_x_px,plan_y_px,input_x_m,input_y_m");
  command->add_flag("--auto", options->automatic, "Find the place without help (the default without --pairs)")
      ->excludes(pairs);
  command
      ->add_option(
          "--mode", options->mode,
          "What follows where the plan was seen: full (all of it), acg (walls as springs, as in the Auto-Complete "
          "Graph), similarity or affine (nothing: the plan is only placed)")
      ->check(CLI::IsMember({"full", "acg", "similarity", "affine"}))
      ->capture_default_str();
  command->add_option("--points", options->points, "Lines of plan_x_px,plan_y_px: where do they lie in the input?");
  command->add_option("--resolution", options->resolution,
                      "Metres per pixel of INPUTs (default: the YAML file's; of a picture 0.05)");
  CLI::Option* correct = command->add_flag("--correct-map", options->correct_map,
                                           "Correct the map of a recorded log by the plan, too, where SLAM alone has "
                                           "bent it or got lost (docs/plan_slam.md)");
  command
      ->add_option("--trajectory", options->trajectory,
                   "With --correct-map: write where the robot was at each scan, lines of `t x y yaw`")
      ->needs(correct);
  command
      ->add_option("--threads", options->threads,
                   "Look for the place on so many processors (default: all). The result is the same")
      ->check(CLI::Range(1, kMostThreads));
  AddLogOptions(*command, options->reading);
  AddNoOdometry(*command, options->reading);
  command->footer(
      "Examples:\n  enfilade prior fit plan.png map.yaml -o out\n"
      "  enfilade prior fit plan.png drive.jsonl --pairs pairs.csv --points corners.csv -o out --json\n"
      "  enfilade prior fit plan.png monday.jsonl tuesday.jsonl -o out");
}

}  // namespace enfilade::cli
