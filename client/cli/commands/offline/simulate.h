// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "client/cli/command.h"

namespace enfilade::cli {

// enfilade simulate -o drive.jsonl: a drive through a few simulated rooms, as a log for `enfilade replay`.
void AddSimulate(CLI::App& app, const Globals& globals);

}  // namespace enfilade::cli
