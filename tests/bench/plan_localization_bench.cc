// SPDX-License-Identifier: Apache-2.0
// How well robots are located in plans that are drawn wrong (core/prior/localization), as JSON on standard output:
//   bench_plan_localization FOLDER... [--variants field,ndt,fixed,nav2] [--starts pairs,global] [--set NAME=VALUE]...
// FOLDER: what `enfilade simulate random:N -o FOLDER --plan-out FOLDER/plan --plan-deform N --seed N` writes.
// tests/bench/plan_localization makes many of them.
//
// Each drive is mapped once and located from two clicks (0.3 m off in each axis, at least 8 m apart, at corners near
// the drive) and from anywhere, at a scale known to 0.8 to 1.25. Where the robot really is in the plan: the affine map
// that fits all corners best, and the mean of what it leaves at the corners around, by exp(-d^2 / (2 (3 m)^2)). A mode
// is right within 1 m and 20 degrees, wrong beyond 1.5 m or 30 degrees.

#include <CLI/CLI.hpp>
#include <Eigen/Dense>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "client/cli/mapped_drive.h"
#include "core/base/error.h"
#include "core/base/noise.h"
#include "core/base/status_macros.h"
#include "core/prior/formats/geojson_plan.h"
#include "core/prior/localization/plan_start.h"
#include "core/prior/localization/submap_tracking.h"
#include "io/file.h"

namespace enfilade::bench {
namespace {

using Eigen::Vector2d;
using nlohmann::json;

constexpr double kUnit = 0.04;      // m per px, of which the simulated plans' axes are 0.8 to 1.25 times
constexpr double kBaseline = 8;     // m
constexpr double kNearDrive = 4;    // m
constexpr double kCheckpoint = 15;  // m

// Where places of the building are in the plan.
class PlanTruth {
 public:
  explicit PlanTruth(const json& truth) {
    for (const json& corner : truth["corners"]) {
      campus_.emplace_back(corner["campus_m"][0], corner["campus_m"][1]);
      sheet_.emplace_back(corner["sheet_px"][0], corner["sheet_px"][1]);
    }
    const auto count = static_cast<Eigen::Index>(campus_.size());
    Eigen::MatrixXd from(count, 3);
    Eigen::MatrixXd to(count, 2);
    for (Eigen::Index i = 0; i < count; ++i) {
      from.row(i) << campus_[static_cast<std::size_t>(i)].transpose(), 1;
      to.row(i) = sheet_[static_cast<std::size_t>(i)].transpose();
    }
    affine_ = from.colPivHouseholderQr().solve(to);
  }
  Vector2d Affine(const Vector2d& p) const { return (Eigen::RowVector3d(p.x(), p.y(), 1) * affine_).transpose(); }
  Vector2d operator()(const Vector2d& p) const {
    Vector2d sum = Vector2d::Zero();
    double weights = 0.05;
    for (std::size_t i = 0; i < campus_.size(); ++i) {
      const double weight = std::exp(-(p - campus_[i]).squaredNorm() / (2 * 3.0 * 3.0));
      sum += weight * (sheet_[i] - Affine(campus_[i]));
      weights += weight;
    }
    return Affine(p) + sum / weights;
  }
  const std::vector<Vector2d>& campus() const { return campus_; }
  const std::vector<Vector2d>& sheet() const { return sheet_; }

 private:
  std::vector<Vector2d> campus_;
  std::vector<Vector2d> sheet_;
  Eigen::Matrix<double, 3, 2> affine_;
};

struct Drive {
  prior::PlanGraph plan;
  prior::MappedDrive mapped;
  std::vector<Pose2> truth;  // of each look, in the campus
  std::vector<prior::ControlPair> clicks;
};

absl::StatusOr<std::vector<Pose2>> TruthOf(const std::filesystem::path& path, const std::vector<TimeNs>& times) {
  ENFILADE_ASSIGN_OR_RETURN(const std::string text, io::ReadFile(path));
  std::istringstream lines(text);
  std::map<TimeNs, Pose2> poses;
  std::string time;
  Pose2 pose;
  while (lines >> time >> pose.x >> pose.y >> pose.yaw) {
    time.erase(std::remove(time.begin(), time.end(), '.'), time.end());  // nine decimals
    poses[std::stoll(time)] = pose;
  }
  std::vector<Pose2> found;
  for (const TimeNs at : times) {
    const auto next = poses.lower_bound(at - 1000);
    if (next == poses.end()) return InvalidArgument("{}: no pose at {}", path.string(), at);
    found.push_back(next->second);
  }
  return found;
}

absl::StatusOr<Drive> ReadDrive(const std::filesystem::path& folder) {
  Drive drive;
  ENFILADE_ASSIGN_OR_RETURN(const std::string plan, io::ReadFile(folder / "plan" / "plan.geojson"));
  ENFILADE_ASSIGN_OR_RETURN(drive.plan, prior::ReadGeoJsonPlan(plan));
  cli::Globals globals;
  globals.quiet = true;
  ENFILADE_ASSIGN_OR_RETURN(drive.mapped, cli::MapDrive(globals, (folder / "robot" / "log.jsonl").string(), {}));
  ENFILADE_ASSIGN_OR_RETURN(drive.truth, TruthOf(folder / "robot" / "truth.txt", drive.mapped.times));
  return drive;
}

// Two corners of the plan near the drive, and where they are in the robot's map, a click's error off.
std::vector<prior::ControlPair> TwoClicks(const PlanTruth& truth, const std::vector<Pose2>& poses, Noise noise) {
  std::vector<std::size_t> near;
  for (std::size_t i = 0; i < truth.campus().size(); ++i) {
    if (std::any_of(poses.begin(), poses.end(),
                    [&](const Pose2& pose) { return (pose.translation() - truth.campus()[i]).norm() < kNearDrive; })) {
      near.push_back(i);
    }
  }
  const Pose2 T_map_campus = Inverse(poses.front());
  for (;;) {
    const std::size_t a = near[static_cast<std::size_t>(noise.Below(static_cast<int>(near.size())))];
    const std::size_t b = near[static_cast<std::size_t>(noise.Below(static_cast<int>(near.size())))];
    if ((truth.campus()[a] - truth.campus()[b]).norm() < kBaseline) continue;
    std::vector<prior::ControlPair> pairs;
    for (const std::size_t corner : {a, b}) {
      const double x = prior::kClickSigma * noise.Normal();
      const double y = prior::kClickSigma * noise.Normal();
      pairs.push_back({truth.sheet()[corner], T_map_campus * truth.campus()[corner] + Vector2d(x, y)});
    }
    return pairs;
  }
}

struct Score {
  double error = 0;     // m
  double turn = 0;      // rad
  double surprise = 0;  // squared, in standard deviations of the position
  bool right() const { return error <= 1.0 && turn <= 20 * kDegree; }
  bool wrong() const { return error > 1.5 || turn > 30 * kDegree; }
};

Score ScoreOf(const prior::PlanField& field, const prior::PlanMode& mode, const PlanTruth& truth, const Pose2& pose) {
  const Vector2d at = field.ToPlan(truth(pose.translation()));
  const Vector2d ahead = field.ToPlan(truth(pose * Vector2d(0.5, 0))) - field.ToPlan(truth(pose * Vector2d(-0.5, 0)));
  const Vector2d heading = prior::LinearOf(mode.mean, field.axis()).col(0);
  const Vector2d off = prior::MetresOf(mode.mean, field.axis()) * (at - mode.mean.translation());
  const Eigen::Matrix2d covariance = mode.covariance.topLeftCorner<2, 2>();
  const double turn = std::atan2(heading.x() * ahead.y() - heading.y() * ahead.x(), heading.dot(ahead));
  return {off.norm(), std::abs(turn), off.dot(covariance.inverse() * off)};
}

json Judge(const prior::PlanField& field, const prior::PlanDrive& drive, const PlanTruth& truth,
           const std::vector<Pose2>& poses, bool list) {
  int steps = 0, right = 0, confident = 0, confident_wrong = 0, tested = 0, held = 0;
  double confident_after = -1;
  std::vector<double> errors;
  bool right_at_checkpoint = false, right_at_end = false;
  for (std::size_t i = 0; i < drive.steps.size(); ++i) {
    const prior::PlanPosterior& step = drive.steps[i];
    if (step.modes.empty()) continue;
    const Score score = ScoreOf(field, step.modes.front(), truth, poses[i]);
    ++steps;
    right += score.right();
    right_at_end = score.right();
    if (step.travelled <= kCheckpoint) right_at_checkpoint = score.right();
    if (list) {
      std::cerr << "step " << step.travelled << " n " << step.particles << " modes " << step.modes.size() << " mass "
                << step.modes.front().mass << " error " << score.error << " turn " << score.turn << " sigmas "
                << std::sqrt(score.surprise) << " matched " << step.matched << (step.confident ? " confident" : "")
                << " scale " << step.modes.front().mean.log_scale << " " << step.modes.front().mean.log_stretch << "\n";
    }
    if (!step.confident) continue;
    if (confident_after < 0) confident_after = step.travelled;
    ++confident;
    confident_wrong += score.wrong();
    if (score.wrong()) continue;
    ++tested;
    held += score.surprise <= 5.991;
    errors.push_back(score.error);
  }
  std::sort(errors.begin(), errors.end());
  int tracked_right = 0;
  for (const prior::TrackedSubmap& submap : drive.submaps) tracked_right += submap.accepted;
  return {{"steps", steps},
          {"right_share", steps > 0 ? static_cast<double>(right) / steps : 0.0},
          {"right_at_15_m", right_at_checkpoint},
          {"right_at_end", right_at_end},
          {"confident_after_m", confident_after},
          {"confident_steps", confident},
          {"confident_wrong_steps", confident_wrong},
          {"tested", tested},
          {"held", held},
          {"median_error_m", errors.empty() ? json() : json(errors[errors.size() / 2])},
          {"submaps", drive.submaps.size()},
          {"submaps_accepted", tracked_right}};
}

using Settings = std::vector<std::pair<std::string, double>>;

absl::Status Set(const Settings& settings, prior::PlanLocalizerOptions& options) {
  const std::map<std::string, double*> numbers = {{"effective_beams", &options.effective_beams},
                                                  {"z_hit", &options.z_hit},
                                                  {"z_rand", &options.z_rand},
                                                  {"sigma_plan", &options.sigma_plan},
                                                  {"sigma_floor", &options.sigma_floor},
                                                  {"stretch_per_metre", &options.stretch_per_metre},
                                                  {"max_range", &options.max_range},
                                                  {"update_distance", &options.update_distance},
                                                  {"translation_noise", &options.translation_noise},
                                                  {"yaw_noise", &options.yaw_noise},
                                                  {"scale_noise", &options.scale_noise},
                                                  {"mirrored_share", &options.mirrored_share},
                                                  {"global_distance", &options.global_distance},
                                                  {"global_density", &options.global_density},
                                                  {"global_sigma", &options.global_sigma},
                                                  {"global_beams", &options.global_beams},
                                                  {"confident_distance", &options.confident_distance},
                                                  {"confident_sigma", &options.confident_sigma},
                                                  {"confident_match", &options.confident_match},
                                                  {"most_recovered", &options.most_recovered},
                                                  {"survey_share", &options.survey_share},
                                                  {"global_aligned", &options.global_aligned},
                                                  {"recent", &options.recent}};
  for (const auto& [name, value] : settings) {
    if (name == "most_unsure") {
      options.most_unsure = static_cast<int>(value);
    } else if (name == "most_global") {
      options.most_global = static_cast<int>(value);
    } else if (numbers.contains(name)) {
      *numbers.at(name) = value;
    } else {
      return InvalidArgument("--set {}: no such option", name);
    }
  }
  return absl::OkStatus();
}

struct BenchOptions {
  std::vector<std::string> folders;
  std::vector<std::string> variants{"field", "ndt", "fixed", "nav2"};
  std::vector<std::string> starts{"pairs", "global"};
  std::vector<std::string> settings;
  std::uint64_t seed = 1;
  bool list = false;
};

absl::StatusOr<json> RunFolder(const std::string& folder, const BenchOptions& bench, const Settings& settings) {
  ENFILADE_ASSIGN_OR_RETURN(Drive drive, ReadDrive(folder));
  ENFILADE_ASSIGN_OR_RETURN(const std::string text,
                            io::ReadFile(std::filesystem::path(folder) / "plan" / "plan-truth.json"));
  const PlanTruth truth(json::parse(text));
  const std::vector<prior::ControlPair> clicks = TwoClicks(truth, drive.truth, Noise(SeedOf(folder)));
  json result = {{"folder", folder}, {"travelled_m", 0.0}};
  for (const std::string& start : bench.starts) {
    const std::vector<prior::ControlPair> pairs = start == "pairs" ? clicks : std::vector<prior::ControlPair>{};
    prior::PlanGraph plan = drive.plan;
    plan.metres_per_unit = kUnit;
    ENFILADE_ASSIGN_OR_RETURN(const double unit, prior::NominalScale(plan, pairs));
    const prior::PlanField field(plan, unit);
    for (const std::string& variant : bench.variants) {
      prior::PlanLocalizerOptions options;
      options.seed = bench.seed;
      ENFILADE_RETURN_IF_ERROR(Set(settings, options));
      if (variant == "ndt") options.sight = prior::PlanSight::kNdt;
      if (variant == "fixed") options.free_scale = false;
      if (variant == "nav2") options = prior::WithNav2Measurement(options);
      if (bench.list) std::cerr << folder << " " << start << " " << variant << "\n";
      const std::clock_t begin = std::clock();
      ENFILADE_ASSIGN_OR_RETURN(const prior::PlanDrive located, LocateDrive(field, pairs, drive.mapped, options));
      const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
      json& judged = result[start][variant] = Judge(field, located, truth, drive.truth, bench.list);
      judged["seconds"] = seconds;
      result["travelled_m"] = located.steps.back().travelled;
    }
  }
  return result;
}

absl::Status RunBench(const BenchOptions& bench) {
  Settings settings;
  for (const std::string& setting : bench.settings) {
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos) return InvalidArgument("--set {}: expected NAME=VALUE", setting);
    settings.emplace_back(setting.substr(0, equals), std::stod(setting.substr(equals + 1)));
  }
  json drives = json::array();
  for (const std::string& folder : bench.folders) {
    ENFILADE_ASSIGN_OR_RETURN(json drive, RunFolder(folder, bench, settings));
    std::cerr << drive.dump() << "\n";
    drives.push_back(std::move(drive));
  }
  json summary;
  for (const std::string& start : bench.starts) {
    for (const std::string& variant : bench.variants) {
      int kept = 0, at_15 = 0, at_end = 0, confident = 0, wrong = 0, tested = 0, held = 0;
      double seconds = 0;
      std::vector<double> after;
      for (const json& drive : drives) {
        const json& one = drive[start][variant];
        kept += one["right_at_end"].get<bool>() && one["right_share"].get<double>() >= 0.95;
        at_15 += one["right_at_15_m"].get<bool>();
        at_end += one["right_at_end"].get<bool>();
        wrong += one["confident_wrong_steps"].get<int>() > 0;
        tested += one["tested"].get<int>();
        held += one["held"].get<int>();
        seconds += one["seconds"].get<double>();
        if (one["confident_after_m"].get<double>() >= 0) {
          ++confident;
          after.push_back(one["confident_after_m"]);
        }
      }
      std::sort(after.begin(), after.end());
      summary[start][variant] = {{"drives", drives.size()},
                                 {"kept", kept},
                                 {"right_at_15_m", at_15},
                                 {"right_at_end", at_end},
                                 {"confident", confident},
                                 {"confident_wrong", wrong},
                                 {"ellipse_held", tested > 0 ? static_cast<double>(held) / tested : 0.0},
                                 {"median_confident_after_m", after.empty() ? json() : json(after[after.size() / 2])},
                                 {"seconds_per_drive", seconds / static_cast<double>(drives.size())}};
    }
  }
  std::cout << json{{"summary", summary}, {"drives", drives}}.dump(1) << "\n";
  return absl::OkStatus();
}

}  // namespace
}  // namespace enfilade::bench

int main(int argc, char** argv) {
  CLI::App app("How well robots are located in plans that are drawn wrong");
  enfilade::bench::BenchOptions options;
  app.add_option("FOLDER", options.folders, "Simulated drives with plans")->required();
  app.add_option("--variants", options.variants)->delimiter(',');
  app.add_option("--starts", options.starts)->delimiter(',');
  app.add_option("--set", options.settings, "NAME=VALUE of an option");
  app.add_option("--seed", options.seed, "Of the localiser");
  app.add_flag("--list", options.list, "List all steps on standard error");
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = enfilade::bench::RunBench(options);
  if (status.ok()) return 0;
  std::cerr << "bench_plan_localization: " << status.message() << "\n";
  return 1;
}
