// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/graph/link_point_search.h"

#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "storage/link_point_store.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/driver/wkb.h"
#include "storage/postgres/graph/graph_change.h"

namespace enfilade::storage {
namespace {

using postgres::Bytes;
using postgres::ExecuteAlone;
using postgres::Params;
using postgres::Row;
using postgres::Statement;

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
constexpr Statement kListLinkPoints{
    "listing link points",
    "SELECT " ENFILADE_LINK_POINT_COLUMNS
    " FROM (SELECT * FROM enfilade.link_points l WHERE site_id = $1 AND link_point_id > $2"
    "   AND ($3::text IS NULL OR EXISTS (SELECT FROM enfilade.link_point_anchors f"
    "     WHERE f.site_id = $1 AND f.link_point_id = l.link_point_id AND f.map_id = $3))"
    "   AND ($4::smallint IS NULL OR kind = $4) AND ($5::smallint IS NULL OR state = $5)"
    "   AND ($6::smallint IS NULL OR \"use\" = $6) AND ($7::boolean IS NULL OR (anchor_count = 1) = $7)"
    "   AND ($8::text IS NULL OR tag = $8)"
    "   ORDER BY link_point_id LIMIT $9) p" ENFILADE_JOIN_ANCHORS " ORDER BY p.link_point_id, a.ordinal"};
constexpr Statement kListInMap{
    "listing a map's link points",
    "SELECT " ENFILADE_LINK_POINT_COLUMNS
    " FROM (SELECT l.* FROM enfilade.link_points l JOIN enfilade.link_point_anchors f"
    "     ON f.site_id = l.site_id AND f.link_point_id = l.link_point_id"
    "   WHERE l.site_id = $1 AND l.link_point_id > $2 AND f.map_id = $3"
    "   AND ($4::smallint IS NULL OR l.kind = $4) AND ($5::smallint IS NULL OR l.state = $5)"
    "   AND ($6::smallint IS NULL OR l.\"use\" = $6) AND ($7::boolean IS NULL OR (l.anchor_count = 1) = $7)"
    "   AND ($8::text IS NULL OR l.tag = $8)"
    "   ORDER BY l.link_point_id LIMIT $9) p" ENFILADE_JOIN_ANCHORS " ORDER BY p.link_point_id, a.ordinal"};

template <typename Enum>
std::optional<std::int16_t> NumberOf(const std::optional<Enum>& value) {
  if (!value) return std::nullopt;
  return static_cast<std::int16_t>(*value);
}

// What all searches share.
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

absl::StatusOr<postgres::Result> FindInCircle(postgres::Pool& pool, const CallContext& context, const SiteId& site,
                                              const LinkPointQuery& query, const LinkPointCircle& circle) {
  if (!circle.center.allFinite()) return InvalidArgument("the center is not finite");
  if (!(circle.radius >= 0.0)) return InvalidArgument("the radius is {}: expected 0 or more", circle.radius);
  const Subset subset(query);
  Params params(site, subset.min_anchors, subset.max_anchors, subset.max_use, subset.limit, circle.center.x(),
                circle.center.y());
  const bool nearest = std::isinf(circle.radius);
  if (!nearest) params.Add(circle.radius);
  if (query.level) params.Add(std::int32_t{*query.level});
  const Statement& statement = nearest ? (query.level ? postgres::kFindNearestOnLevel : postgres::kFindNearest)
                                       : (query.level ? postgres::kFindWithinOnLevel : postgres::kFindWithin);
  return storage::postgres::ExecuteAlone(pool, context, statement, params);
}

absl::StatusOr<postgres::Result> FindInPolygon(postgres::Pool& pool, const CallContext& context, const SiteId& site,
                                               const LinkPointQuery& query,
                                               const std::vector<Eigen::Vector2d>& polygon) {
  if (polygon.size() < 3) return InvalidArgument("the polygon has {} corners: at least 3 are needed", polygon.size());
  for (const Eigen::Vector2d& corner : polygon) {
    if (!corner.allFinite()) return InvalidArgument("the polygon has a corner that is not finite");
  }
  const Subset subset(query);
  const std::string wkb = postgres::EncodePolygon(polygon);
  Params params(site, subset.min_anchors, subset.max_anchors, subset.max_use, subset.limit, Bytes{wkb});
  if (query.level) params.Add(std::int32_t{*query.level});
  return storage::postgres::ExecuteAlone(pool, context, query.level ? kFindInPolygonOnLevel : kFindInPolygon, params);
}

}  // namespace

absl::StatusOr<FoundLinkPoints> LinkPointStore::Find(const CallContext& context, const SiteId& site,
                                                     const LinkPointQuery& query) const {
  const auto* circle = std::get_if<LinkPointCircle>(&query.area);
  ENFILADE_ASSIGN_OR_RETURN(
      const postgres::Result result,
      circle ? FindInCircle(pool_, context, site, query, *circle)
             : FindInPolygon(pool_, context, site, query, std::get<std::vector<Eigen::Vector2d>>(query.area)));
  FoundLinkPoints found;
  ENFILADE_ASSIGN_OR_RETURN(found.link_points, postgres::ReadLinkPoints(result));
  if (result.rows() == 0) {
    ENFILADE_ASSIGN_OR_RETURN(
        const auto graph, storage::postgres::ExecuteAlone(pool_, context, postgres::kSelectGraphVersion, Params(site)));
    ENFILADE_ASSIGN_OR_RETURN(found.graph_version, postgres::ReadGraphVersion(graph));
  } else {
    Row last(result, 0, result.columns() - 1);
    found.graph_version = last.Int64();
    ENFILADE_RETURN_IF_ERROR(last.status());
  }
  return found;
}

absl::StatusOr<std::vector<StoredLinkPoint>> LinkPointStore::ListUnplaced(const CallContext& context,
                                                                          const SiteId& site, int limit) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result, storage::postgres::ExecuteAlone(pool_, context, kListUnplaced,
                                                                               Params(site, std::int64_t{limit})));
  return postgres::ReadLinkPoints(result);
}

absl::StatusOr<std::vector<StoredLinkPoint>> LinkPointStore::List(const CallContext& context, const SiteId& site,
                                                                  const LinkPointFilter& filter,
                                                                  const PageRequest& page) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result,
                            storage::postgres::ExecuteAlone(
                                pool_, context, filter.map ? kListInMap : kListLinkPoints,
                                Params(site, page.after, filter.map, NumberOf(filter.kind), NumberOf(filter.state),
                                       NumberOf(filter.use), filter.candidate, filter.tag, std::int64_t{page.limit})));
  return postgres::ReadLinkPoints(result);
}

}  // namespace enfilade::storage
