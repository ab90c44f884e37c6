// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/geometry/pose2.h"
#include "core/grid/map_raster.h"

namespace enfilade::grid {

// The YAML file beside a map's image, as Nav2's and ROS 1's map_server read it.
struct MapYaml {
  std::string image{};      // the image file, relative to the YAML file or absolute
  double resolution = 0.0;  // m per pixel
  Pose2 origin{};           // of the image's lower-left corner, in the map's frame
  GreyInterpretation interpretation{};
};

struct ParsedMapYaml {
  MapYaml yaml;
  std::vector<std::string> warnings;  // in words; what was read all the same
};

// Keys: image, resolution, origin ([x, y, yaw], exactly three), occupied_thresh, free_thresh, negate (an integer or a
// Boolean): all required; mode: trinary (where absent), scale or raw. `dialect` is kept in the interpretation; both
// dialects have the same keys. INVALID_ARGUMENT naming the key and, where the parser knows it, the line (from 1):
// missing or of another type, an empty image, a resolution that is not positive, anything not finite.
//
// Unknown keys are ignored, as map_server does; a warning names each. So does one for thresholds the wrong way round,
// which map_server takes without a word.
absl::StatusOr<ParsedMapYaml> ParseMapYaml(std::string_view text, MapDialect dialect);

// Nav2's keys in Nav2's order. Numbers have the fewest digits that give the same double when read back (Nav2's own
// writer rounds resolution and origin to millimetres). `image` must need no quotes.
std::string FormatMapYaml(const MapYaml& yaml);

}  // namespace enfilade::grid
