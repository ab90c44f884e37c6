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
  std::vector<std::string> warnings;  // human-readable; the file was read nevertheless
};

// Keys: image, resolution, origin ([x, y, yaw], exactly three), occupied_thresh, free_thresh, negate (an integer or a
// Boolean): all required; mode: trinary (default), scale or raw. `dialect` is kept in the interpretation; both dialects
// have the same keys. INVALID_ARGUMENT naming the key and, if known, the line (from 1): missing or of another type, an
// empty image, a resolution that is not positive, a number that is not finite.
//
// Unknown keys are ignored, as in map_server, with a warning each. Swapped thresholds, which map_server accepts
// silently, give a warning too.
absl::StatusOr<ParsedMapYaml> ParseMapYaml(std::string_view text, MapDialect dialect);

// Nav2's keys in Nav2's order. Numbers have the fewest digits that read back as the same double (Nav2's own writer
// rounds resolution and origin to millimetres). `image` must not need quotes.
std::string FormatMapYaml(const MapYaml& yaml);

}  // namespace enfilade::grid
