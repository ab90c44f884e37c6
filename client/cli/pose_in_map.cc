// SPDX-License-Identifier: Apache-2.0
#include "client/cli/pose_in_map.h"

#include <optional>
#include <vector>

#include "client/cli/numbers.h"
#include "core/base/error.h"

namespace enfilade::cli {

absl::StatusOr<PoseInMap> ParsePoseInMap(const std::string& text) {
  std::string map = text;
  std::vector<double> numbers;  // from the last
  while (numbers.size() < 3) {
    const std::size_t comma = map.rfind(',');
    if (comma == std::string::npos) break;
    const std::optional<double> number = ParseNumber(map.substr(comma + 1));
    if (!number) break;
    numbers.push_back(*number);
    map.resize(comma);
  }
  if (numbers.size() < 2 || map.empty()) {
    return InvalidArgument("\"{}\" is not a pose in a map: expected MAP,X,Y or MAP,X,Y,YAW in metres and radians",
                           text);
  }
  if (numbers.size() == 2) return PoseInMap{map, {numbers[1], numbers[0], 0.0}};
  return PoseInMap{map, {numbers[2], numbers[1], numbers[0]}};
}

}  // namespace enfilade::cli
