// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace enfilade::io {

struct ProgramResult {
  int exit_code = 0;
  std::string output;
  std::string errors;  // what it wrote to standard error
};

struct ProgramLimits {
  std::chrono::seconds time{30};
  std::size_t output_bytes = std::size_t{256} << 20;
};

// Runs a program that the search path has, with `input` on its standard input, and waits for its end. No shell is
// involved. NOT_FOUND: there is no such program; DEADLINE_EXCEEDED, RESOURCE_EXHAUSTED: a limit was passed, the program
// was killed; INTERNAL: it was ended by a signal.
absl::StatusOr<ProgramResult> RunProgram(const std::vector<std::string>& command, std::string_view input,
                                         const ProgramLimits& limits = {});

}  // namespace enfilade::io
