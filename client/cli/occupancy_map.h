// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "absl/status/statusor.h"
#include "core/grid/occupancy_grid.h"

namespace enfilade::cli {

// A map's YAML or JSON file, or a picture of a map (grid::ReadPlan): the frame of a picture has its origin at the lower
// left corner, x to the right, y up. `resolution`: metres per pixel instead of the file's. Errors name the path.
absl::StatusOr<grid::OccupancyGrid> ReadOccupancyMap(const std::filesystem::path& path,
                                                     std::optional<double> resolution);

}  // namespace enfilade::cli
