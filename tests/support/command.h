// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace enfilade::testing {

struct CommandResult {
  int exit_code = 0;   // or 128 + the signal that ended it
  std::string output;  // stdout and stderr
};

// A file of the project, such as "deploy/database/migrate".
std::string ProjectFile(const std::string& relative);

// Runs a program and waits for it. `environment`: "NAME=value", added to this process's.
CommandResult RunCommand(const std::vector<std::string>& command, const std::vector<std::string>& environment = {});

}  // namespace enfilade::testing
