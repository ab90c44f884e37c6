// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/commands.h"

namespace enfilade::cli {

void AddMatch(CLI::App& app, const Globals& globals) {
  CLI::App* match = app.add_subcommand("match", "Find out whether two images or two point clouds show the same place");
  match->require_subcommand(1);
  AddMatchImages(*match, globals);
  AddMatchClouds(*match, globals);
}

}  // namespace enfilade::cli
