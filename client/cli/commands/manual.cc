// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <memory>
#include <string>

#include "client/cli/commands/commands.h"
#include "core/base/status_macros.h"
#include "core/base/version.h"
#include "io/file.h"
#include "io/manual/man_page.h"

namespace enfilade::cli {
namespace {

// Each command has a page of its own; the tool's lists them.
std::string CommandList(const CLI::App& app) {
  std::string list;
  for (const CLI::App* command : app.get_subcommands({})) {
    list += fmt::format("  enfilade-{}(1)\n      {}\n", command->get_name(), command->get_description());
  }
  return list;
}

absl::Status WritePages(const CLI::App& app, const std::filesystem::path& folder) {
  io::ManPageOptions options;
  options.version = kVersion;
  options.see_also = ".BR enfilade (1),\n.BR enfilade\\-server (8)";
  for (const CLI::App* command : app.get_subcommands({})) {
    ENFILADE_RETURN_IF_ERROR(io::WriteFile(folder / fmt::format("enfilade-{}.1", command->get_name()),
                                           io::ManPage(*command, "enfilade " + command->get_name(), options)));
  }
  options.commands = false;
  options.see_also = ".BR enfilade\\-server (8),\n.BR enfilade\\-gateway (8)";
  options.sections = {
      {"COMMANDS", CommandList(app)},
      {"EXIT STATUS",
       "0: done; 2: wrong usage or input; 3: not found; 4: the server does not answer or is not ready; 1: "
       "any other error."}};
  return io::WriteFile(folder / "enfilade.1", io::ManPage(app, "enfilade", options));
}

}  // namespace

void AddManual(CLI::App& app) {
  auto folder = std::make_shared<std::string>();
  CLI::App* command = AddCommand(app, "manual", "Write the manual pages of all commands into a folder",
                                 [&app, folder] { return WritePages(app, *folder); });
  command->add_option("FOLDER", *folder, "The folder, which exists")->required();
  command->footer("Example: enfilade manual . && man ./enfilade-map.1");
}

}  // namespace enfilade::cli
