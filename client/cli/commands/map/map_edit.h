// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "CLI/CLI.hpp"
#include "client/cli/command.h"

namespace enfilade::cli {

// enfilade map create | update
void AddMapEdit(CLI::App& map, const Globals& globals);

}  // namespace enfilade::cli
