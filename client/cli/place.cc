#include "client/cli/place.h"

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
