// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/doors/door_options.h"

namespace enfilade::robot {

// What of the images and clouds goes into the log.
struct EvidenceOptions {
  int images = 6;              // of each camera behind a door (num_last_imgs; the original's loop takes one more)
  double max_age = 2.0;        // s: what is farther from a moment than this is not of it
  double spacing = 0.1;        // m to be driven between two images of a camera that are kept in memory
  double turn = 10.0;          // deg to be turned, likewise
  int kept = 64;               // images of each camera, and clouds, in memory
  double report_behind = 2.0;  // m behind the door at which a passage is reported
  double report_after = 8.0;   // s after which it is reported in any case
  double all_hz = 0.0;         // images and clouds recorded everywhere, of each kind; 0: near doors only
};

// Indoors or outdoors behind a door: the SLAM configuration of a new map.
struct ChoiceOptions {
  int criterion = 0;              // config_criterion: 0 range, 1 SSIM, 2 PSNR, 3 scene classifier
  double range_thr = 13.0;        // m (code: 10.0)
  int low_pass_filter_size = 60;  // beams to either side
  double ssim_thr = 0.7;
  double psnr_thr = 0.0;    // dB
  int num_depth_imgs = 10;  // (code: 5)
  std::string scene_model;  // files of criterion 3, as in `enfilade environment`
  std::string scene_labels;
  std::string scene_mapping;
};

struct SpoolLimits {
  double max_mib = 4096.0;
  // A full spool holds the source up; false: what the sensors deliver is refused and counted until there is room.
  bool wait_when_full = true;
};

// The options of a robot's agent. In YAML (ParseRobotOptions) the original's params.yaml names hold; docs/robot.md.
struct RobotOptions {
  bool automatic = true;              // doors are found by the detector; false: a person says all
  bool record_imgs_and_pc = true;     // evidence is recorded
  bool use_global_tracker = true;     // asks for and shows the robot's pose in the world
  double initial_variance_x = 0.003;  // m^2, of a pose that is given by hand
  double initial_variance_y = 0.003;
  double initial_variance_theta = 0.003;  // rad^2
  ChoiceOptions choice;
  EvidenceOptions evidence;
  SpoolLimits spool;
  doors::DoorOptions doors;

  // INVALID_ARGUMENT naming the option.
  absl::Status Validate() const;
};

// "default", "original-yaml" or "original-code": doors and choice as there. INVALID_ARGUMENT naming these.
absl::StatusOr<RobotOptions> RobotPreset(std::string_view name);

// Options from YAML on top of `base`; `preset: NAME` in the file replaces the base. Beside the names that
// FormatRobotOptions prints the original's names of door options hold (deriv_door_thr and others). INVALID_ARGUMENT
// naming key and line: a key that does not exist, one that the server has, an option that comes twice under two names,
// a value of another type, what Validate refuses.
absl::StatusOr<RobotOptions> ParseRobotOptions(std::string_view yaml, const RobotOptions& base);
// All options as YAML with a comment each, which ParseRobotOptions reads back to the same values.
std::string FormatRobotOptions(const RobotOptions& options);

}  // namespace enfilade::robot
