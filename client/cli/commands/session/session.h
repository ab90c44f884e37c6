// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "client/cli/command.h"

namespace enfilade::cli {

// `enfilade session list|show`.
void AddSession(CLI::App& app, const Globals& globals);

}  // namespace enfilade::cli
