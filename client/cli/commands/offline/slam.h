// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "client/cli/command.h"

namespace enfilade::cli {

// `enfilade slam LOG`: the server's SLAM, run here on a file.
void AddSlam(CLI::App& app, const Globals& globals);

}  // namespace enfilade::cli
