#pragma once

#include "client/cli/command.h"

namespace enfilade::cli {

// `enfilade server status`.
void AddServer(CLI::App& app, const Globals& globals);

}  // namespace enfilade::cli
