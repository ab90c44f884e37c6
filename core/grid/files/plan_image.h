// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "absl/status/statusor.h"
#include "core/grid/occupancy_grid.h"

namespace enfilade::grid {

// Reads a picture of a map or floor plan (PNG or PGM) that has no YAML file beside it: white is free, and a light to
// middle grey that fills at least a twentieth of the picture is the unknown around the building. Everything else,
// walls and furniture of any grey, is occupied. Transparent pixels are unknown. The resolution is 0.05 m and the origin
// zero: a picture does not say. INVALID_ARGUMENT: neither PNG nor PGM, or damaged.
absl::StatusOr<OccupancyGrid> ReadPlan(std::string_view bytes);

}  // namespace enfilade::grid
