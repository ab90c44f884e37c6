// SPDX-License-Identifier: Apache-2.0
#include "core/areas/area_files.h"

#include <algorithm>
#include <string>
#include <utility>

#include "core/areas/area_mask.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace enfilade::areas {
namespace {

// The image, and its YAML file with `comments` (lines that begin with "#") before it.
absl::StatusOr<std::vector<grid::MapFile>> RenderMask(const grid::MapRaster& raster, const char* stem,
                                                      const std::string& comments) {
  ENFILADE_ASSIGN_OR_RETURN(std::vector<grid::MapFile> files,
                            grid::RenderFiles(raster, stem, {.format = grid::MapFileFormat::kPgm}));
  for (grid::MapFile& file : files) {
    if (file.name.ends_with(".yaml")) file.bytes.insert(0, comments);
  }
  return files;
}

// A name as a part of a comment: without line ends, which would end it.
std::string OnOneLine(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; }, ' ');
  return text;
}

// A number that ROS 2 reads as floating-point: with a point.
std::string AsFloatingPoint(double number) {
  std::string text = fmt::format("{:.9g}", number);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

}  // namespace

absl::StatusOr<std::vector<grid::MapFile>> RenderKeepOutMask(const std::vector<MapArea>& areas,
                                                             const grid::GridGeometry& geometry) {
  return RenderMask(KeepOutMask(areas, geometry), "keepout",
                    "# A filter mask for Nav2's KeepoutFilter. Parameters of its costmap_filter_info_server:\n"
                    "#   type: 0\n"
                    "#   base: 0.0\n"
                    "#   multiplier: 1.0\n");
}

absl::StatusOr<std::vector<grid::MapFile>> RenderSpeedMask(const std::vector<MapArea>& areas,
                                                           const grid::GridGeometry& geometry) {
  ENFILADE_ASSIGN_OR_RETURN(const SpeedMask mask, MakeSpeedMask(areas, geometry));
  std::string comments = fmt::format(
      "# A filter mask for Nav2's SpeedFilter, in m/s. Parameters of its costmap_filter_info_server:\n"
      "#   type: 2\n"
      "#   base: 0.0\n"
      "#   multiplier: {}\n",
      AsFloatingPoint(mask.multiplier));
  for (const RoundedSpeed& speed : mask.rounded) {
    comments += fmt::format("# \"{}\": {} m/s is said as {:.6g} m/s.\n", OnOneLine(speed.area), speed.wanted_mps,
                            speed.said_mps);
  }
  return RenderMask(mask.raster, "speed", comments);
}

}  // namespace enfilade::areas
