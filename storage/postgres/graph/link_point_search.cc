// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/graph/link_point_search.h"

#include <cmath>
#include <limits>

#include "core/base/status_macros.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/driver/wkb.h"
#include "storage/postgres/graph/graph_versions.h"

namespace enfilade::storage::postgres {
namespace {

#define ENFILADE_FIND_IN_POLYGON(level)                                                               \
  "WITH found AS MATERIALIZED (SELECT * FROM enfilade.link_points WHERE site_id = $1"                 \
  " AND ST_Intersects(position, ST_GeomFromWKB($6, 0))" level                                         \
  " AND anchor_count BETWEEN $2 AND $3 AND \"use\" <= $4 ORDER BY link_point_id LIMIT $5)"            \
  " SELECT " ENFILADE_LINK_POINT_COLUMNS ENFILADE_GRAPH_VERSION " FROM found p" ENFILADE_JOIN_ANCHORS \
  " ORDER BY p.link_point_id, a.ordinal"

constexpr Statement kFindInPolygonOnLevel{"looking for link points",
                                          ENFILADE_FIND_IN_POLYGON(" AND levels @> $7::integer")};
constexpr Statement kFindInPolygon{"looking for link points", ENFILADE_FIND_IN_POLYGON("")};
constexpr Statement kListUnplaced{"listing link points without a place",
                                  "SELECT " ENFILADE_LINK_POINT_COLUMNS
                                  " FROM (SELECT * FROM enfilade.link_points WHERE site_id = $1 AND position IS NULL"
                                  "   ORDER BY link_point_id LIMIT $2) p" ENFILADE_JOIN_ANCHORS
                                  " ORDER BY p.link_point_id, a.ordinal"};
// A parameter that is NULL filters nothing.
#define ENFILADE_LIST_LINK_POINTS(in_map)                                                                  \
  "SELECT " ENFILADE_LINK_POINT_COLUMNS " FROM (SELECT l.* FROM enfilade.link_points l" in_map             \
  "   WHERE l.site_id = $1 AND l.link_point_id > $2"                                                       \
  "   AND ($3::smallint IS NULL OR l.kind = $3) AND ($4::smallint IS NULL OR l.state = $4)"                \
  "   AND ($5::smallint IS NULL OR l.\"use\" = $5) AND ($6::boolean IS NULL OR (l.anchor_count = 1) = $6)" \
  "   AND ($7::text IS NULL OR l.tag = $7)"                                                                \
  "   ORDER BY l.link_point_id LIMIT $8) p" ENFILADE_JOIN_ANCHORS " ORDER BY p.link_point_id, a.ordinal"

constexpr Statement kListAll{"listing link points", ENFILADE_LIST_LINK_POINTS("")};
// A separate statement: as one more optional filter, the map would not use its index.
constexpr Statement kListInMap{"listing a map's link points",
                               ENFILADE_LIST_LINK_POINTS(" JOIN enfilade.link_point_anchors f ON f.site_id = l.site_id"
                                                         " AND f.link_point_id = l.link_point_id AND f.map_id = $9")};

template <typename Enum>
std::optional<std::int16_t> NumberOf(const std::optional<Enum>& value) {
  if (!value) return std::nullopt;
  return static_cast<std::int16_t>(*value);
}

// The parameters that all searches share.
struct Subset {
  explicit Subset(const LinkPointQuery& query)
      : min_anchors(query.candidate == false ? 2 : 1),
        max_anchors(query.candidate == true ? 1 : std::numeric_limits<std::int32_t>::max()),
        max_use(query.with_unused ? std::int16_t{3} : std::int16_t{1}),
        limit(query.limit) {}

  std::int32_t min_anchors;
  std::int32_t max_anchors;
  std::int16_t max_use;
  std::int64_t limit;
};

absl::StatusOr<Result> FindInCircle(Pool& pool, const CallContext& context, const SiteId& site,
                                    const LinkPointQuery& query, const LinkPointCircle& circle) {
  const Subset subset(query);
  Params params(site, subset.min_anchors, subset.max_anchors, subset.max_use, subset.limit, circle.center.x(),
                circle.center.y());
  const bool nearest = std::isinf(circle.radius);
  if (!nearest) params.Add(circle.radius);
  if (query.level) params.Add(std::int32_t{*query.level});
  const Statement& statement =
      nearest ? (query.level ? kFindNearestOnLevel : kFindNearest) : (query.level ? kFindWithinOnLevel : kFindWithin);
  return ExecuteAlone(pool, context, statement, params);
}

absl::StatusOr<Result> FindInPolygon(Pool& pool, const CallContext& context, const SiteId& site,
                                     const LinkPointQuery& query, const std::vector<Eigen::Vector2d>& polygon) {
  const Subset subset(query);
  const std::string wkb = EncodePolygon(polygon);
  Params params(site, subset.min_anchors, subset.max_anchors, subset.max_use, subset.limit, Bytes{wkb});
  if (query.level) params.Add(std::int32_t{*query.level});
  return ExecuteAlone(pool, context, query.level ? kFindInPolygonOnLevel : kFindInPolygon, params);
}

}  // namespace

absl::StatusOr<FoundLinkPoints> FindLinkPoints(Pool& pool, const CallContext& context, const SiteId& site,
                                               const LinkPointQuery& query) {
  ENFILADE_RETURN_IF_ERROR(ValidateQuery(query));
  const auto* circle = std::get_if<LinkPointCircle>(&query.area);
  ENFILADE_ASSIGN_OR_RETURN(
      const Result result,
      circle ? FindInCircle(pool, context, site, query, *circle)
             : FindInPolygon(pool, context, site, query, std::get<std::vector<Eigen::Vector2d>>(query.area)));
  FoundLinkPoints found;
  ENFILADE_ASSIGN_OR_RETURN(found.link_points, ReadLinkPoints(result));
  if (result.rows() == 0) {
    ENFILADE_ASSIGN_OR_RETURN(const auto graph, ExecuteAlone(pool, context, kSelectGraphVersion, Params(site)));
    ENFILADE_ASSIGN_OR_RETURN(found.graph_version, ReadGraphVersion(graph));
  } else {
    Row last(result, 0, result.columns() - 1);
    found.graph_version = last.Int64();
    ENFILADE_RETURN_IF_ERROR(last.status());
  }
  return found;
}

absl::StatusOr<std::vector<StoredLinkPoint>> ListUnplacedLinkPoints(Pool& pool, const CallContext& context,
                                                                    const SiteId& site, int limit) {
  ENFILADE_ASSIGN_OR_RETURN(const auto result,
                            ExecuteAlone(pool, context, kListUnplaced, Params(site, std::int64_t{limit})));
  return ReadLinkPoints(result);
}

absl::StatusOr<std::vector<StoredLinkPoint>> ListLinkPoints(Pool& pool, const CallContext& context, const SiteId& site,
                                                            const LinkPointFilter& filter, const PageRequest& page) {
  Params params(site, page.after, NumberOf(filter.kind), NumberOf(filter.state), NumberOf(filter.use), filter.candidate,
                filter.tag, std::int64_t{page.limit});
  if (filter.map) params.Add(*filter.map);
  ENFILADE_ASSIGN_OR_RETURN(const auto result, ExecuteAlone(pool, context, filter.map ? kListInMap : kListAll, params));
  return ReadLinkPoints(result);
}

}  // namespace enfilade::storage::postgres
