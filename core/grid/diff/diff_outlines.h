// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "absl/status/statusor.h"
#include "core/grid/diff/changed_runs.h"

namespace enfilade::grid {

struct DiffLattice;

// The GeoJSON of MapDiffOptions::with_geojson: the `max_features` largest groups of both lists, which are grouped.
// RESOURCE_EXHAUSTED above 500,000 corners.
absl::StatusOr<std::string> OutlinesToGeoJson(const ChangedRuns& came, const ChangedRuns& went,
                                              const DiffLattice& lattice, std::size_t max_features);

}  // namespace enfilade::grid
