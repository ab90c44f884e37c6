// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "client/cli/command.h"

namespace enfilade::cli {

// enfilade match images A B, enfilade match clouds SOURCE TARGET: what closes loops at doors, on files.
void AddMatch(CLI::App& app, const Globals& globals);

void AddMatchImages(CLI::App& match, const Globals& globals);
void AddMatchClouds(CLI::App& match, const Globals& globals);

}  // namespace enfilade::cli
