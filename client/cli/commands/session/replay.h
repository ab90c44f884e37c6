// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "client/cli/command.h"

namespace enfilade::cli {

// enfilade replay LOG --map NAME: brings a recorded log to the server as a robot would.
void AddReplay(CLI::App& app, const Globals& globals);

}  // namespace enfilade::cli
