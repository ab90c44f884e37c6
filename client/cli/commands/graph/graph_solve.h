// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "client/cli/command.h"

namespace enfilade::cli {

// enfilade graph solve FILE [-o OUT]: the optimum of a pose graph in g2o or TORO form.
void AddGraph(CLI::App& app, const Globals& globals);

}  // namespace enfilade::cli
