// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/commands.h"

namespace enfilade::cli {

void AddPrior(CLI::App& app, const Globals& globals) {
  CLI::App* prior = app.add_subcommand("prior", "Floor plans as prior maps: read their walls, fit them to maps");
  prior->require_subcommand(1);
  AddPriorFit(*prior, globals);
  AddPriorImport(*prior, globals);
}

}  // namespace enfilade::cli
