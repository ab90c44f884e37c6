// SPDX-License-Identifier: Apache-2.0
#include "client/cli/place.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <vector>

#include "core/base/error.h"

namespace enfilade::cli {
namespace {

std::optional<double> ToNumber(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || end != text.c_str() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace

std::optional<std::vector<double>> ParseNumbers(const std::string& text, std::size_t count) {
  std::vector<double> numbers;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t comma = std::min(text.find(',', begin), text.size());
    const std::optional<double> number = ToNumber(text.substr(begin, comma - begin));
    if (!number) return std::nullopt;
    numbers.push_back(*number);
    begin = comma + 1;
  }
  if (numbers.size() != count) return std::nullopt;
  return numbers;
}

absl::StatusOr<Place> ParsePlace(const std::string& text) {
  std::string map = text;
  std::vector<double> numbers;  // from the last
  while (numbers.size() < 3) {
    const std::size_t comma = map.rfind(',');
    if (comma == std::string::npos) break;
    const std::optional<double> number = ToNumber(map.substr(comma + 1));
    if (!number) break;
    numbers.push_back(*number);
    map.resize(comma);
  }
  if (numbers.size() < 2 || map.empty()) {
    return InvalidArgument("\"{}\" is no place: expected MAP,X,Y or MAP,X,Y,YAW in metres and radians", text);
  }
  if (numbers.size() == 2) return Place{map, {numbers[1], numbers[0], 0.0}};
  return Place{map, {numbers[2], numbers[1], numbers[0]}};
}

}  // namespace enfilade::cli
