// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "client/cli/command.h"

namespace enfilade::cli {

// `enfilade server status`.
void AddServer(CLI::App& app, const Globals& globals);

}  // namespace enfilade::cli
