// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace enfilade::cli {

// One finite number and nothing else; unset otherwise.
std::optional<double> ParseNumber(const std::string& text);

// `count` finite numbers separated by commas; unset otherwise.
std::optional<std::vector<double>> ParseNumbers(const std::string& text, std::size_t count);

// The option --rate, how fast recorded entries are played: "max" is unset (as fast as possible), "real" is 1, any other
// positive number is a factor. INVALID_ARGUMENT.
absl::StatusOr<std::optional<double>> ParseRate(const std::string& text);

}  // namespace enfilade::cli
