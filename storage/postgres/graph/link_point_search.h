// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "storage/graph/link_point_store.h"
#include "storage/postgres/driver/connection.h"
#include "storage/postgres/driver/pool.h"
#include "storage/postgres/graph/link_point_rows.h"

namespace enfilade::storage::postgres {

// The statements of FindLinkPoints are public so that the benchmark can give the same ones to pgbench. The inner query
// is the indexed search; the outer one adds the anchors and the graph's version to its rows.
#define ENFILADE_GRAPH_VERSION ", (SELECT graph_version FROM enfilade.site_graphs WHERE site_id = $1)"
#define ENFILADE_FIND_LINK_POINTS(area, level)                                                        \
  "WITH found AS MATERIALIZED (SELECT * FROM enfilade.link_points WHERE site_id = $1" area level      \
  " AND anchor_count BETWEEN $2 AND $3 AND \"use\" <= $4"                                             \
  " ORDER BY position <-> ST_MakePoint($6, $7) LIMIT $5)"                                             \
  " SELECT " ENFILADE_LINK_POINT_COLUMNS ENFILADE_GRAPH_VERSION " FROM found p" ENFILADE_JOIN_ANCHORS \
  " ORDER BY p.position <-> ST_MakePoint($6, $7), p.link_point_id, a.ordinal"
#define ENFILADE_WITHIN " AND ST_DWithin(position, ST_MakePoint($6, $7), $8)"

constexpr Statement kFindWithinOnLevel{"looking for link points",
                                       ENFILADE_FIND_LINK_POINTS(ENFILADE_WITHIN, " AND levels @> $9::integer")};
constexpr Statement kFindWithin{"looking for link points", ENFILADE_FIND_LINK_POINTS(ENFILADE_WITHIN, "")};
constexpr Statement kFindNearestOnLevel{
    "looking for the nearest link points",
    ENFILADE_FIND_LINK_POINTS(" AND position IS NOT NULL", " AND levels @> $8::integer")};
constexpr Statement kFindNearest{"looking for the nearest link points",
                                 ENFILADE_FIND_LINK_POINTS(" AND position IS NOT NULL", "")};

// As the methods of LinkPointStore.
absl::StatusOr<FoundLinkPoints> FindLinkPoints(Pool& pool, const CallContext& context, const SiteId& site,
                                               const LinkPointQuery& query);
absl::StatusOr<std::vector<StoredLinkPoint>> ListLinkPoints(Pool& pool, const CallContext& context, const SiteId& site,
                                                            const LinkPointFilter& filter, const PageRequest& page);
absl::StatusOr<std::vector<StoredLinkPoint>> ListUnplacedLinkPoints(Pool& pool, const CallContext& context,
                                                                    const SiteId& site, int limit);

}  // namespace enfilade::storage::postgres
