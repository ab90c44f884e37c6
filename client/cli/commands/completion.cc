// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>
#include <string>

#include "client/cli/commands/commands.h"
#include "core/base/error.h"

namespace enfilade::cli {
namespace {

// What may follow a command: its subcommands and options.
std::string WordsOf(const CLI::App& command, const CLI::App& root) {
  std::string words;
  for (const CLI::App* subcommand : command.get_subcommands({})) words += subcommand->get_name() + " ";
  for (const CLI::App* owner : {&command, &root}) {
    for (const CLI::Option* option : owner->get_options()) {
      for (const std::string& name : option->get_lnames()) words += "--" + name + " ";
    }
    if (owner == &root) break;
  }
  return words;
}

// One branch of the shell's case for each command: "map export".
void AppendCases(const CLI::App& command, const CLI::App& root, const std::string& path, std::string& script) {
  script += fmt::format("    '{}') words='{}' ;;\n", path, WordsOf(command, root));
  for (const CLI::App* subcommand : command.get_subcommands({})) {
    AppendCases(*subcommand, root, path.empty() ? subcommand->get_name() : path + " " + subcommand->get_name(), script);
  }
}

// Completes what may follow the longest run of words that names a command, and file names otherwise.
std::string BashScript(const CLI::App& app) {
  std::string script =
      "_enfilade() {\n"
      "  local current=${COMP_WORDS[COMP_CWORD]} path='' words='' word\n"
      "  for word in \"${COMP_WORDS[@]:1:COMP_CWORD-1}\"; do\n"
      "    case \"$word\" in -*) continue ;; esac\n"
      "    case \" $_enfilade_commands \" in *\" ${path:+${path// /.}.}$word \"*) path=${path:+$path }$word ;; esac\n"
      "  done\n"
      "  case \"$path\" in\n";
  AppendCases(app, app, "", script);
  script +=
      "  esac\n"
      "  COMPREPLY=($(compgen -W \"$words\" -- \"$current\"))\n"
      "}\n"
      "complete -o default -F _enfilade enfilade\n";
  return script;
}

// All commands, with dots between their words: "map map.export ...".
void AppendCommands(const CLI::App& command, const std::string& path, std::string& list) {
  for (const CLI::App* subcommand : command.get_subcommands({})) {
    const std::string name = path.empty() ? subcommand->get_name() : path + "." + subcommand->get_name();
    list += name + " ";
    AppendCommands(*subcommand, name, list);
  }
}

absl::Status Print(const CLI::App& app, const std::string& shell) {
  if (shell != "bash" && shell != "zsh") return InvalidArgument("shell \"{}\": expected bash or zsh", shell);
  if (shell == "zsh") std::cout << "autoload -U +X bashcompinit && bashcompinit\n";
  std::string commands;
  AppendCommands(app, "", commands);
  std::cout << "_enfilade_commands='" << commands << "'\n" << BashScript(app);
  return absl::OkStatus();
}

}  // namespace

void AddCompletion(CLI::App& app) {
  auto shell = std::make_shared<std::string>();
  CLI::App* command = AddCommand(app, "completion", "Print a completion script for bash or zsh",
                                 [&app, shell] { return Print(app, *shell); });
  command->add_option("SHELL", *shell, "bash or zsh")->required();
  command->footer("Example: source <(enfilade completion bash)");
}

}  // namespace enfilade::cli
