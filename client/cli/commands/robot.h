// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "client/cli/command.h"

namespace enfilade::cli {

// `enfilade robot`: map a campus as a robot does (docs/robot.md).
void AddRobot(CLI::App& app, const Globals& globals);

}  // namespace enfilade::cli
