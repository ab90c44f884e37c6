// SPDX-License-Identifier: Apache-2.0
#include "client/cli/log_options.h"

#include <cmath>

namespace enfilade::cli {

void AddLogOptions(CLI::App& command, sources::LogOptions& options) {
  command.add_flag("--skip-bad-lines", options.skip_bad_lines,
                   "Skip lines of the log that cannot be read, and count them");
  command.add_option("--range-max", options.range_max, "Ranges of this or more mean \"no return\", m");
  command
      .add_option_function<double>(
          "--fov", [&options](double degrees) { options.field_of_view = degrees * M_PI / 180.0; },
          "Field of view of scans that do not state theirs, degrees")
      ->check(CLI::Range(0.01, 360.0));
}

void AddNoOdometry(CLI::App& command, sources::LogOptions& options) {
  command.add_flag_callback(
      "--no-odometry", [&options] { options.odometry = false; }, "Use only the scans");
}

}  // namespace enfilade::cli
