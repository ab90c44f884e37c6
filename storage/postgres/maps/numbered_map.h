// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "core/base/ids.h"
#include "storage/postgres/driver/transaction.h"

namespace enfilade::storage::postgres {

// Doubles the number until it is free, and then halves the distance to one that is taken: as many looks into an index
// as the number of maps has digits, twice. The graph is locked: no other transaction can take the same number.
inline constexpr Statement kInsertNumberedMap{
    "making the map",
    "WITH RECURSIVE search (taken, free, bounded) AS ("
    "  SELECT 0::bigint, 1::bigint, false"
    "  UNION ALL SELECT CASE WHEN t.is_taken THEN p.number ELSE p.taken END,"
    "    CASE WHEN NOT t.is_taken THEN p.number WHEN p.bounded THEN p.free ELSE 2 * p.number END,"
    "    p.bounded OR NOT t.is_taken"
    "  FROM (SELECT s.*, CASE WHEN s.bounded THEN (s.taken + s.free) / 2 ELSE s.free END AS number FROM search s"
    "      WHERE NOT s.bounded OR s.free - s.taken > 1) p"
    "    CROSS JOIN LATERAL (SELECT EXISTS (SELECT FROM enfilade.maps"
    "      WHERE site_id = $1 AND display_name = $3 || ' ' || p.number) AS is_taken) t)"
    " INSERT INTO enfilade.maps (site_id, map_id, display_name, level, environment, slam_profile)"
    " SELECT $1, $2, $3 || ' ' || free, $4, $5, $6 FROM search WHERE bounded AND free - taken = 1"};

// Makes a map (storage::NewMap, rearrange::MapSeed) whose display name is its prefix and a free number, the one before
// which is taken: the smallest free one unless maps with smaller numbers have been removed. The graph's version is
// raised by a trigger: the caller notifies of it (NotifyOfPresentGraph).
template <typename NewMap>
void QueueNumberedMap(Transaction& transaction, const SiteId& site, const NewMap& map) {
  transaction.Queue(kInsertNumberedMap, Params(site, map.id, map.name_prefix, std::int32_t{map.level},
                                               static_cast<std::int16_t>(map.environment), map.slam_profile));
}

}  // namespace enfilade::storage::postgres
