// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "CLI/CLI.hpp"
#include "client/cli/command.h"

namespace enfilade::cli {

// enfilade import mapmanager | building
void AddImport(CLI::App& app, const Globals& globals);

}  // namespace enfilade::cli
