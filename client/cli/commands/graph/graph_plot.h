// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "CLI/CLI.hpp"
#include "client/cli/command.h"

namespace enfilade::cli {

// `plot` below `enfilade graph`: the site's maps and link points as a PNG or SVG.
void AddGraphPlot(CLI::App& graph, const Globals& globals);

}  // namespace enfilade::cli
