// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/commands/prior/plan_options.h"
#include "client/cli/commands/prior/prior_fit_files.h"
#include "client/cli/commands/prior/prior_locate_files.h"
#include "client/cli/commands/prior/prior_locate_stored.h"
#include "client/cli/log_options.h"
#include "client/cli/mapped_drive.h"
#include "client/cli/output.h"
#include "client/sources/log_reader.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/prior/localization/plan_start.h"
#include "core/prior/localization/submap_tracking.h"
#include "core/prior/plan/plan_check.h"
#include "fmt/format.h"
#include "io/file.h"
#include "perception/plan/read_plan.h"

namespace enfilade::cli {
namespace {

using Clock = std::chrono::steady_clock;

struct PriorLocateOptions {
  PlanOptions plan;
  std::string log;
  std::string session;
  std::string pairs;
  std::string model{prior::NameOf(prior::PlanSight::kField)};
  std::string output;
  std::string plot;
  bool fixed_scale = false;
  bool nav2 = false;
  std::uint64_t seed = 1;
  sources::LogOptions reading;
  const CLI::App* command = nullptr;  // says which options were given
};

prior::PlanLocalizerOptions ToLocalizerOptions(const PriorLocateOptions& options) {
  prior::PlanLocalizerOptions localizing;
  localizing.seed = options.seed;
  localizing.sight = prior::PlanSightFrom(options.model).value();  // the command line has checked it
  localizing.free_scale = !options.fixed_scale;
  return options.nav2 ? prior::WithNav2Measurement(localizing) : localizing;
}

absl::Status LocateInFile(const Globals& globals, const PriorLocateOptions& options) {
  if (!options.session.empty())
    return InvalidArgument("--session is for plans of a site: {} is a file", options.plan.path);
  if (options.log.empty()) return InvalidArgument("prior locate: LOG is missing");
  ENFILADE_ASSIGN_OR_RETURN(const perception::ReadPlanOptions reading, ToReadOptions(options.plan));
  ENFILADE_ASSIGN_OR_RETURN(const prior::PlanGraph plan, perception::ReadPlan(options.plan.path, reading));
  ENFILADE_RETURN_IF_ERROR(prior::CheckPlan(plan));
  std::vector<prior::ControlPair> pairs;
  if (!options.pairs.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(pairs, ReadPairs(options.pairs));
    if (pairs.empty()) return InvalidArgument("{}: no pairs in it", options.pairs);
    for (prior::ControlPair& pair : pairs) pair.point_sheet = prior::ToSheet(plan, pair.point_sheet);
  }
  ENFILADE_ASSIGN_OR_RETURN(const double metres_per_unit, prior::NominalScale(plan, pairs));
  const prior::PlanField field(plan, metres_per_unit);
  ENFILADE_ASSIGN_OR_RETURN(const prior::MappedDrive mapped, MapDrive(globals, options.log, options.reading));
  const Clock::time_point begin = Clock::now();
  ENFILADE_ASSIGN_OR_RETURN(const prior::PlanDrive drive,
                            prior::LocateDrive(field, pairs, mapped, ToLocalizerOptions(options)));
  const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();

  const nlohmann::json report = LocatedReport(field, drive, seconds);
  if (!options.output.empty()) {
    nlohmann::json all = report;
    all["steps"] = LocatedSteps(field, drive, mapped.times);
    ENFILADE_RETURN_IF_ERROR(io::WriteFile(options.output, all.dump(1) + "\n"));
  }
  if (!options.plot.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(const std::string png, PlotLocated(field, drive));
    ENFILADE_RETURN_IF_ERROR(io::WriteFile(options.plot, png));
  }
  if (globals.json) {
    PrintJson(std::cout, report);
  } else {
    std::cout << DescribeLocated(field, drive, seconds);
  }
  return absl::OkStatus();
}

// What is there as a file is read here; anything else means a plan of the site.
absl::Status RunPriorLocate(const Globals& globals, const PriorLocateOptions& options) {
  if (std::filesystem::exists(options.plan.path)) return LocateInFile(globals, options);
  for (const char* option : {"--measure", "--page", "--layers", "--level", "--model", "--fixed-scale", "--nav2",
                             "--seed", "--output", "--plot"}) {
    if (options.command->count(option) > 0) {
      return InvalidArgument("{}: \"{}\" is no file, and of a site's plan that option cannot be set", option,
                             options.plan.path);
    }
  }
  return LocateInStoredPlan(globals, {options.plan.path, options.log, options.reading, options.session, options.pairs});
}

}  // namespace

void AddPriorLocate(CLI::App& prior, const Globals& globals) {
  auto options = std::make_shared<PriorLocateOptions>();
  CLI::App* command = AddCommand(prior, "locate", "Locate a robot in a floor plan that nobody has corrected",
                                 [&globals, options] { return RunPriorLocate(globals, *options); });
  options->command = command;
  AddPlanOptions(*command, options->plan);
  command->get_option("PLAN")->description(
      "A file (docs/prior_maps.md lists the formats), or the name, id or resource name of a plan of the site");
  command->add_option("LOG", options->log, "A recorded log (docs/logs.md lists the formats)");
  command->add_option("--session", options->session,
                      "By a session of the site that is mapped, instead of a log: its id; points of --pairs are in the "
                      "frame of its map");
  command->add_option("--pairs", options->pairs,
                      "Points that are known in both: lines of plan_x_px,plan_y_px,x_m,y_m, in the frame in which the "
                      "log's first scan is at 0,0 and looks along x. Default: the robot may be anywhere");
  command
      ->add_option("--model", options->model,
                   "What is compared with the plan: field (the ends of beams) or ndt (normal distributions of what "
                   "was seen lately)")
      ->check(CLI::IsMember({"field", "ndt"}))
      ->capture_default_str();
  command->add_flag("--fixed-scale", options->fixed_scale, "The plan's scale is right, the same along both axes");
  command->add_flag("--nav2", options->nav2, "Weigh scans as Nav2's AMCL does by default, for comparison");
  command->add_option("--seed", options->seed, "Of the random numbers")->capture_default_str();
  command->add_option("-o,--output", options->output, "Write where it may be after each keyframe into this JSON file");
  command->add_option("--plot", options->plot, "Draw the drive and the particles over the plan into this PNG file");
  AddLogOptions(*command, options->reading);
  AddNoOdometry(*command, options->reading);
  command->footer(
      "Examples:\n  enfilade prior locate plan.png drive.jsonl --pairs pairs.csv --plot located.png\n"
      "  enfilade prior locate plan.png drive.jsonl --measure 120,40,480,40=7.2 -o located.json\n"
      "  enfilade prior locate \"Ground floor\" drive.jsonl --timeout 120 --json\n"
      "  enfilade prior locate \"Ground floor\" --session monday");
}

}  // namespace enfilade::cli
