// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "io/tls/tls_files.h"

namespace enfilade::cli {

// The options of all commands.
struct Globals {
  bool json = false;                       // print JSON instead of text
  bool quiet = false;                      // no progress bars
  std::string server = "localhost:50051";  // host:port or unix:/path
  double timeout_s = 30.0;                 // deadline of a unary call
  std::string site = "default";
  std::string actor;  // for the audit trail
  io::TlsParts tls;   // without authorities: no TLS
};

// Adds the subcommand `name` to `parent` and returns it, so that options can be added. `run` is called if the command
// line names it; its error is printed as "enfilade: message" and sets the exit code (ExitCodeOf).
CLI::App* AddCommand(CLI::App& parent, const std::string& name, const std::string& description,
                     std::function<absl::Status()> run);

// 0 OK, 2 INVALID_ARGUMENT (usage and input), 3 NOT_FOUND, 4 UNAVAILABLE and DEADLINE_EXCEEDED, 1 everything else.
int ExitCodeOf(const absl::Status& status);

// Thrown through CLI11's callbacks by AddCommand; caught in main.
struct CommandFailed {
  absl::Status status;
};

}  // namespace enfilade::cli
