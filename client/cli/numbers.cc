// SPDX-License-Identifier: Apache-2.0
#include "client/cli/numbers.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/base/error.h"

namespace enfilade::cli {

std::optional<double> ParseNumber(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || end != text.c_str() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<std::vector<double>> ParseNumbers(const std::string& text, std::size_t count) {
  std::vector<double> numbers;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t comma = std::min(text.find(',', begin), text.size());
    const std::optional<double> number = ParseNumber(text.substr(begin, comma - begin));
    if (!number) return std::nullopt;
    numbers.push_back(*number);
    begin = comma + 1;
  }
  if (numbers.size() != count) return std::nullopt;
  return numbers;
}

absl::StatusOr<std::optional<double>> ParseRate(const std::string& text) {
  if (text == "max") return std::nullopt;
  if (text == "real") return 1.0;
  const std::optional<double> rate = ParseNumber(text);
  if (rate && *rate > 0.0) return rate;
  return InvalidArgument("--rate is \"{}\": expected max, real or a factor such as 2.5", text);
}

}  // namespace enfilade::cli
