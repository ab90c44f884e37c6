// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "CLI/CLI.hpp"

namespace enfilade::io {

// What a manual page says beside what the command itself knows.
struct ManPageOptions {
  int section = 1;       // 1 commands of users, 8 of administrators
  std::string version;   // of the program
  bool commands = true;  // with what the subcommands take
  std::string see_also;  // "enfilade\-server(8)", in roff; empty: none
  // Further sections: title, and its content in plain text. A line that begins with a space is kept as it is.
  std::vector<std::pair<std::string, std::string>> sections;
};

// The manual page of a command with its subcommands, for man(7), made of what its --help says. `path`: the whole
// command, such as "enfilade map".
std::string ManPage(const CLI::App& command, const std::string& path, const ManPageOptions& options);

}  // namespace enfilade::io
