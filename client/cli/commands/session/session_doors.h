// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "client/cli/command.h"

namespace enfilade::cli {

// `enfilade session doors`: what was made of a session's door reports.
void AddSessionDoors(CLI::App& session, const Globals& globals);

}  // namespace enfilade::cli
