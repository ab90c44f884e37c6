// SPDX-License-Identifier: Apache-2.0
#include "client/cli/command.h"

#include <utility>

namespace enfilade::cli {

CLI::App* AddCommand(CLI::App& parent, const std::string& name, const std::string& description,
                     std::function<absl::Status()> run) {
  CLI::App* command = parent.add_subcommand(name, description);
  command->callback([run = std::move(run)] {
    if (absl::Status status = run(); !status.ok()) throw CommandFailed{std::move(status)};
  });
  return command;
}

int ExitCodeOf(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kOk:
      return 0;
    case absl::StatusCode::kInvalidArgument:
      return 2;
    case absl::StatusCode::kNotFound:
      return 3;
    case absl::StatusCode::kUnavailable:
    case absl::StatusCode::kDeadlineExceeded:
      return 4;
    default:
      return 1;
  }
}

}  // namespace enfilade::cli
