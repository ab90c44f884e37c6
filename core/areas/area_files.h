// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "core/areas/map_area.h"
#include "core/grid/files/map_files.h"

namespace enfilade::areas {

// Masks as files for Nav2's map server: keepout.pgm and keepout.yaml, speed.pgm and speed.yaml. The YAML files begin
// with comments that say how to configure Nav2's CostmapFilterInfoServer (type, base, multiplier), and which speeds are
// rounded.
absl::StatusOr<std::vector<grid::MapFile>> RenderKeepOutMask(const std::vector<MapArea>& areas,
                                                             const grid::GridGeometry& geometry);
// Errors as MakeSpeedMask.
absl::StatusOr<std::vector<grid::MapFile>> RenderSpeedMask(const std::vector<MapArea>& areas,
                                                           const grid::GridGeometry& geometry);

}  // namespace enfilade::areas
