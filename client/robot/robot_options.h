// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/doors/door_options.h"

namespace enfilade::robot {

// Which images and clouds are recorded.
struct EvidenceOptions {
  int images = 6;                // from each camera behind a door (num_last_imgs)
  double max_age = 2.0;          // s: images and clouds farther from a moment than this do not show it
  double spacing = 0.1;          // m driven between two images of a camera, or clouds, that are kept in memory
  double turn = 10.0;            // deg turned between them, instead
  int kept = 64;                 // images of each camera, and clouds, in memory
  double report_behind = 2.0;    // m behind the door at which a passage is reported
  double report_after = 8.0;     // s after which it is reported in any case
  double report_standing = 2.0;  // s of standing behind the door after which it is reported
  double all_hz = 0.0;           // rate of images of each camera, and clouds, recorded everywhere; 0: near doors only
};

// How indoors or outdoors is decided, which chooses the SLAM configuration of a new map.
struct EnvironmentOptions {
  int criterion = 0;              // config_criterion: 0 range, 1 SSIM, 2 PSNR, 3 scene classifier
  double range_thr = 13.0;        // m (original-code: 10.0)
  int low_pass_filter_size = 60;  // beams to either side
  double ssim_thr = 0.7;
  double psnr_thr = 0.0;    // dB
  int num_depth_imgs = 10;  // (original-code: 5)
  std::string scene_model;  // files of criterion 3, as in `enfilade environment`
  std::string scene_labels;
  std::string scene_mapping;
};

struct SpoolLimits {
  double max_mib = 4096.0;
  // true: the source waits while the spool is full; false: sensor data is refused and counted until there is space.
  bool wait_when_full = true;
};

// The options of a robot's agent, in YAML named as in map_manager's params.yaml (docs/robot.md).
struct RobotOptions {
  bool automatic = true;              // doors come from the detector; false: from commands
  bool record_imgs_and_pc = true;     // evidence is recorded
  bool use_global_tracker = true;     // the robot's pose in the world is polled and shown
  double initial_variance_x = 0.003;  // m^2, of a pose given by a command
  double initial_variance_y = 0.003;
  double initial_variance_theta = 0.003;  // rad^2
  EnvironmentOptions environment;
  EvidenceOptions evidence;
  SpoolLimits spool;
  doors::DoorOptions doors;

  // INVALID_ARGUMENT naming the option.
  absl::Status Validate() const;
};

// "default"; "original-yaml" and "original-code": doors and environment as in map_manager's params.yaml and as its code
// defaults to. INVALID_ARGUMENT naming these.
absl::StatusOr<RobotOptions> RobotPreset(std::string_view name);

// Options from YAML on top of `base`; `preset: NAME` in the file replaces the base. Besides the names that
// FormatRobotOptions prints, map_manager's names of door options are accepted (deriv_door_thr and others).
// INVALID_ARGUMENT with key and line: an unknown key, a key of the server's options, an option that is set twice under
// two names, a value of the wrong type, what Validate refuses.
absl::StatusOr<RobotOptions> ParseRobotOptions(std::string_view yaml, const RobotOptions& base);
// All options as YAML with a comment each. ParseRobotOptions reads the same values back.
std::string FormatRobotOptions(const RobotOptions& options);

}  // namespace enfilade::robot
