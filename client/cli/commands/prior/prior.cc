// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/commands.h"

namespace enfilade::cli {

void AddPrior(CLI::App& app, const Globals& globals) {
  CLI::App* prior =
      app.add_subcommand("prior", "Floor plans as prior maps of a site; import, fit and locate work on files alone");
  prior->require_subcommand(1);
  AddPriorAdd(*prior, globals);
  AddPriorAlign(*prior, globals);
  AddPriorEdit(*prior, globals);
  AddPriorExport(*prior, globals);
  AddPriorPublish(*prior, globals);
  AddPriorFit(*prior, globals);
  AddPriorImport(*prior, globals);
  AddPriorLocate(*prior, globals);
  AddPriorMaps(*prior, globals);
  AddPriorTies(*prior, globals);
}

}  // namespace enfilade::cli
