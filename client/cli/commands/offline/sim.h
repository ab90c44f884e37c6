// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "client/cli/command.h"

namespace enfilade::cli {

// enfilade sim CAMPUS -o DIR: robots drive through a simulated campus; logs, truth and a plan.
void AddSim(CLI::App& app, const Globals& globals);

}  // namespace enfilade::cli
