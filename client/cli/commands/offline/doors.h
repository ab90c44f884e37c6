// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "client/cli/command.h"

namespace enfilade::cli {

// enfilade doors LOG: the door detector on a recorded log; events as JSON lines.
void AddDoors(CLI::App& app, const Globals& globals);

}  // namespace enfilade::cli
