// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "client/cli/command.h"

namespace enfilade::cli {

// `export` and `import` below `enfilade map`.
void AddMapExport(CLI::App& map, const Globals& globals);
void AddMapImport(CLI::App& map, const Globals& globals);

}  // namespace enfilade::cli
