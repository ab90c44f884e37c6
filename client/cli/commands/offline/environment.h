// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "client/cli/command.h"

namespace enfilade::cli {

// enfilade environment LOG|IMAGES...: indoors or outdoors, by the criteria that choose a new map's configuration.
void AddEnvironment(CLI::App& app, const Globals& globals);

}  // namespace enfilade::cli
