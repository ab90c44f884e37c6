// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "CLI/CLI.hpp"
#include "client/sources/log_reader.h"

namespace enfilade::cli {

// --skip-bad-lines, --range-max and --fov: what a log does not state itself. `options` outlives the command.
void AddLogOptions(CLI::App& command, sources::LogOptions& options);
// --no-odometry.
void AddNoOdometry(CLI::App& command, sources::LogOptions& options);

}  // namespace enfilade::cli
