// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "client/cli/command.h"

namespace enfilade::cli {

// `enfilade completion bash|zsh`: a script made from the commands that `app` has when it is called.
void AddCompletion(CLI::App& app);

}  // namespace enfilade::cli
