// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "CLI/CLI.hpp"
#include "client/cli/command.h"

namespace enfilade::cli {

// enfilade graph show | versions | optimize | export | plot, below the command "graph" that is there already.
void AddGraphRemote(CLI::App& app, const Globals& globals);

}  // namespace enfilade::cli
