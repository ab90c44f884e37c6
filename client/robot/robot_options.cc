// SPDX-License-Identifier: Apache-2.0
#include "client/robot/robot_options.h"

#include <array>
#include <cmath>

#include "core/base/status_macros.h"
#include "core/options/yaml_options.h"

namespace enfilade::robot {
namespace {

constexpr std::string_view kWhat = "robot options";

// Calls visit("group.name", value, comment) for every option but those of the door detector. `Options` is RobotOptions,
// const or not.
template <typename Options, typename Visit>
void VisitOwn(Options& o, Visit visit) {
  visit("automatic", o.automatic, "doors come from the detector; false: from commands");
  visit("record_imgs_and_pc", o.record_imgs_and_pc, "images and clouds near doors are recorded");
  visit("use_global_tracker", o.use_global_tracker, "the pose in the world is polled and shown");
  visit("initial_variance_x", o.initial_variance_x, "m^2, of a pose given by a command");
  visit("initial_variance_y", o.initial_variance_y, "m^2");
  visit("initial_variance_theta", o.initial_variance_theta, "rad^2");
  visit("config_criterion", o.environment.criterion,
        "indoors or outdoors by: 0 range, 1 SSIM, 2 PSNR, 3 scene classifier");
  visit("range_thr", o.environment.range_thr, "m: criterion 0, outdoors if two sides are farther");
  visit("low_pass_filter_size", o.environment.low_pass_filter_size, "criterion 0: beams to either side");
  visit("ssim_thr", o.environment.ssim_thr, "criterion 1: below it is outdoors");
  visit("psnr_thr", o.environment.psnr_thr, "dB: criterion 2, below it is outdoors");
  visit("num_depth_imgs", o.environment.num_depth_imgs, "criteria 1 and 2");
  visit("scene_model", o.environment.scene_model, "criterion 3: the network, ONNX");
  visit("scene_labels", o.environment.scene_labels, "criterion 3: its classes");
  visit("scene_mapping", o.environment.scene_mapping, "criterion 3: each class indoor (1) or outdoor (2)");
  visit("num_last_imgs", o.evidence.images, "images from each camera behind a door");
  visit("evidence.max_age", o.evidence.max_age, "s: images and clouds farther from a moment than this do not show it");
  visit("evidence.spacing", o.evidence.spacing, "m driven between two images kept in memory");
  visit("evidence.turn", o.evidence.turn, "deg turned between them, instead");
  visit("evidence.kept", o.evidence.kept, "images of each camera, and clouds, in memory");
  visit("evidence.report_behind", o.evidence.report_behind, "m behind the door at which a passage is reported");
  visit("evidence.report_after", o.evidence.report_after, "s after which it is reported in any case");
  visit("evidence.report_standing", o.evidence.report_standing, "s of standing behind it after which it is reported");
  visit("evidence.all_hz", o.evidence.all_hz, "rate of images and clouds recorded everywhere; 0: near doors only");
  visit("spool.max_mib", o.spool.max_mib, "the largest size of the spool file");
  visit("spool.wait_when_full", o.spool.wait_when_full,
        "true: the source waits while the spool is full; false: sensor data is refused");
}

// map_manager's names of door options, and the names here.
constexpr std::array<std::pair<const char*, const char*>, 4> kAliases = {{
    {"deriv_door_thr", "derivative.threshold"},
    {"time_limit_door_detection", "time_limit"},
    {"deriv_range_thr", "environment.change"},
    {"low_pass_filter_size_env", "environment.filter_half_width"},
}};

// map_manager's parameters of what the server does here.
constexpr std::array<const char*, 4> kServerOptions = {"feature_matching_thr", "NNDR_akaze", "NNDR_sift",
                                                       "icp_fitness_score_thr"};

absl::Status Positive(const char* name, double value) {
  if (value > 0.0 && std::isfinite(value)) return absl::OkStatus();
  return InvalidArgument("{} is {}: expected a number above 0", name, value);
}

absl::Status ValidateEnvironment(const EnvironmentOptions& o) {
  if (o.criterion < 0 || o.criterion > 3) {
    return InvalidArgument("config_criterion is {}: expected 0 (range), 1 (SSIM), 2 (PSNR) or 3 (scene classifier)",
                           o.criterion);
  }
  ENFILADE_RETURN_IF_ERROR(Positive("range_thr", o.range_thr));
  if (o.low_pass_filter_size < 0) {
    return InvalidArgument("low_pass_filter_size is {}: expected 0 or more", o.low_pass_filter_size);
  }
  if (o.num_depth_imgs < 2) return InvalidArgument("num_depth_imgs is {}: expected 2 or more", o.num_depth_imgs);
  if (!std::isfinite(o.ssim_thr) || !std::isfinite(o.psnr_thr)) {
    return InvalidArgument("ssim_thr and psnr_thr must be finite");
  }
  if (o.criterion == 3 && (o.scene_model.empty() || o.scene_labels.empty() || o.scene_mapping.empty())) {
    return InvalidArgument("config_criterion is 3: set scene_model, scene_labels and scene_mapping");
  }
  return absl::OkStatus();
}

absl::Status ValidateEvidence(const EvidenceOptions& o) {
  if (o.images < 1) return InvalidArgument("num_last_imgs is {}: expected 1 or more", o.images);
  if (o.kept < o.images) {
    return InvalidArgument("evidence.kept is {}: expected at least num_last_imgs, {}", o.kept, o.images);
  }
  ENFILADE_RETURN_IF_ERROR(Positive("evidence.max_age", o.max_age));
  ENFILADE_RETURN_IF_ERROR(Positive("evidence.report_after", o.report_after));
  ENFILADE_RETURN_IF_ERROR(Positive("evidence.report_standing", o.report_standing));
  for (const auto& [name, value] :
       {std::pair("evidence.spacing", o.spacing), std::pair("evidence.turn", o.turn),
        std::pair("evidence.report_behind", o.report_behind), std::pair("evidence.all_hz", o.all_hz)}) {
    if (!(value >= 0.0) || !std::isfinite(value)) return InvalidArgument("{} is {}: expected 0 or more", name, value);
  }
  return absl::OkStatus();
}

absl::Status ApplyAliases(yaml_options::Values& values) {
  for (const char* name : kServerOptions) {
    if (const auto found = values.find(name); found != values.end()) {
      return InvalidArgument(
          "{}: {} is not an option of the robot: doors are judged on the server (docs/robot.md names its option)",
          yaml_options::Location(kWhat, found->second.Mark()), name);
    }
  }
  for (const auto& [alias, option] : kAliases) {
    const auto found = values.find(alias);
    if (found == values.end()) continue;
    if (!values.emplace(option, found->second).second) {
      return InvalidArgument("{}: {} is set twice: it is an alias of {}",
                             yaml_options::Location(kWhat, found->second.Mark()), alias, option);
    }
    values.erase(alias);
  }
  return absl::OkStatus();
}

std::string Quoted(const std::string& text) { return fmt::format("'{}'", text); }
template <typename T>
T Quoted(T value) {
  return value;
}

}  // namespace

absl::Status RobotOptions::Validate() const {
  ENFILADE_RETURN_IF_ERROR(Positive("initial_variance_x", initial_variance_x));
  ENFILADE_RETURN_IF_ERROR(Positive("initial_variance_y", initial_variance_y));
  ENFILADE_RETURN_IF_ERROR(Positive("initial_variance_theta", initial_variance_theta));
  ENFILADE_RETURN_IF_ERROR(ValidateEnvironment(environment));
  ENFILADE_RETURN_IF_ERROR(ValidateEvidence(evidence));
  if (!(spool.max_mib >= 1.0)) return InvalidArgument("spool.max_mib is {}: expected 1 or more", spool.max_mib);
  return doors.Validate();
}

absl::StatusOr<RobotOptions> RobotPreset(std::string_view name) {
  RobotOptions options;
  ENFILADE_ASSIGN_OR_RETURN(options.doors, doors::DoorPreset(name));
  if (name == "original-code") {
    options.environment.range_thr = 10.0;
    options.environment.num_depth_imgs = 5;
  }
  return options;
}

absl::StatusOr<RobotOptions> ParseRobotOptions(std::string_view yaml, const RobotOptions& base) {
  ENFILADE_ASSIGN_OR_RETURN(yaml_options::Values values, yaml_options::Load(yaml, kWhat));
  RobotOptions options = base;
  if (const auto preset = values.find("preset"); preset != values.end()) {
    absl::StatusOr<RobotOptions> named = RobotPreset(preset->second.Scalar());
    if (!named.ok()) {
      return WithContext(named.status(), yaml_options::Location(kWhat, preset->second.Mark()));
    }
    options = *std::move(named);
  }
  ENFILADE_RETURN_IF_ERROR(ApplyAliases(values));
  const auto visit = [&](auto visitor) {
    VisitOwn(options, [&](const char* name, auto& value, const char*) { visitor(name, value); });
    doors::VisitDoorOptions(options.doors, visitor);
  };
  ENFILADE_RETURN_IF_ERROR(yaml_options::Assign(values, kWhat, visit, {"preset"}));
  ENFILADE_RETURN_IF_ERROR(options.Validate());
  return options;
}

std::string FormatRobotOptions(const RobotOptions& options) {
  const bool gap = options.doors.method == doors::DoorMethod::kGap;
  std::string text = fmt::format("preset: {}  # or {}; everything below is set on top of it\n",
                                 gap ? "default" : "original-yaml", gap ? "original-yaml, original-code" : "default");
  std::string group;
  const auto line = [&](const std::string& name, const std::string& value, const std::string& comment) {
    const std::size_t dot = name.find('.');
    const std::string of = dot == std::string::npos ? "" : name.substr(0, dot);
    if (of != group && !of.empty()) text += of + ":\n";
    group = of;
    const std::string setting = dot == std::string::npos ? name : "  " + name.substr(dot + 1);
    text += fmt::format("{}: {}{}\n", setting, value, comment.empty() ? "" : "  # " + comment);
  };
  VisitOwn(options, [&](const char* name, const auto& value, const char* comment) {
    line(name, fmt::format("{}", Quoted(value)), comment);
  });
  text += "# doors: docs/doors.md\n";
  doors::VisitDoorOptions(options.doors, [&](const char* name, const auto& value) {
    std::string comment;
    for (const auto& [alias, option] : kAliases) {
      if (std::string_view(option) == name) comment = alias;
    }
    line(name, fmt::format("{}", value), comment);
  });
  return text;
}

}  // namespace enfilade::robot
