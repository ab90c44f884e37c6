#pragma once

#include "client/cli/command.h"

namespace enfilade::cli {

// `enfilade closure list|suspend|resume`.
void AddClosure(CLI::App& app, const Globals& globals);

}  // namespace enfilade::cli
