// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "storage/maps/prior_map_store.h"
#include "storage/postgres/driver/rows.h"

namespace enfilade::storage::postgres {

// Those of an alignment are empty without one.
#define ENFILADE_PRIOR_MAP_COLUMNS                                                                                     \
  "site_id, prior_map_id, display_name, level, state, reason, file_name, warnings, walls, corners, doors, rooms,"      \
  " shafts, metres_per_unit, etag, create_time, update_time, align_time, coalesce(affine, '{}'),"                      \
  " coalesce(model, 2::smallint), coalesce(explained, 0), coalesce(contradicted, 0), coalesce(rival_ratio, 0),"        \
  " coalesce(aligned_maps, '{}'), coalesce(graph_version, 0), coalesce(pair_maps, '{}'), coalesce(pair_points, '{}')," \
  " coalesce(tied_walls, 0), coalesce(joined_maps, '{}')"

// Of a row with these columns.
PriorMap ReadPriorMap(Row& row);

}  // namespace enfilade::storage::postgres
