// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "client/cli/command.h"

namespace enfilade::cli {

// `enfilade map list|show|delete`, and by map_transfer.h `export|import`.
void AddMap(CLI::App& app, const Globals& globals);

}  // namespace enfilade::cli
