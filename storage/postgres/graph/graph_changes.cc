// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/graph/graph_changes.h"

#include <algorithm>
#include <optional>
#include <span>
#include <string>

#include "core/base/environment.h"
#include "core/base/resource_name.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/driver/wkb.h"
#include "storage/postgres/graph/link_point_rows.h"

namespace enfilade::storage::postgres {
namespace {

constexpr Statement kSelectGraph{"reading the graph's version",
                                 "SELECT coalesce(g.graph_version, 0), g.root_map_id,"
                                 " coalesce(g.forgotten_version, 0) FROM enfilade.sites s"
                                 " LEFT JOIN enfilade.site_graphs g USING (site_id) WHERE site_id = $1"
                                 " AND s.delete_time IS NULL"};
constexpr Statement kShareGraph{"locking the graph's version",
                                "SELECT graph_version FROM enfilade.site_graphs WHERE site_id = $1 FOR SHARE"};
#define ENFILADE_MAP_COLUMNS                                                                          \
  "m.map_id, m.display_name, m.level, m.environment, ST_AsBinary(m.outline, 'NDR'), g.x IS NOT NULL," \
  " coalesce(g.x, 0), coalesce(g.y, 0), coalesce(g.yaw, 0), coalesce(g.covariance, '{}'), g.changed_version"
constexpr Statement kSelectMaps{"reading the graph's maps", "SELECT " ENFILADE_MAP_COLUMNS
                                                            " FROM enfilade.graph_maps g JOIN enfilade.maps m"
                                                            " ON m.site_id = g.site_id AND m.map_id = g.map_id"
                                                            " WHERE g.site_id = $1 ORDER BY m.map_id"};
constexpr Statement kSelectLinkPoints{"reading the graph's link points",
                                      "SELECT " ENFILADE_LINK_POINT_COLUMNS
                                      " FROM enfilade.link_points p" ENFILADE_JOIN_ANCHORS
                                      " WHERE p.site_id = $1 ORDER BY p.link_point_id, a.ordinal"};
// What has changed is little, but PostgreSQL may take it for half of a site: it knows how versions are distributed over
// all sites together, not in one. A range whose two ends it does not know when it plans is taken to be narrow, and
// OFFSET 0 keeps it from reading the joined table as a whole.
#define ENFILADE_IS_CHANGED(version) \
  version " > (SELECT $2::bigint) AND " version " <= (SELECT $2::bigint) + 1000000000000"
constexpr Statement kSelectChangedMaps{
    "reading the graph's changed maps",
    "SELECT " ENFILADE_MAP_COLUMNS
    " FROM enfilade.graph_maps g CROSS JOIN LATERAL"
    " (SELECT map_id, display_name, level, environment, outline FROM enfilade.maps"
    "   WHERE site_id = $1 AND map_id = g.map_id OFFSET 0) m"
    " WHERE g.site_id = $1 AND " ENFILADE_IS_CHANGED("g.changed_version") " ORDER BY m.map_id"};
constexpr Statement kSelectChangedLinkPoints{
    "reading the graph's changed link points",
    "SELECT " ENFILADE_LINK_POINT_COLUMNS
    " FROM enfilade.link_points p CROSS JOIN LATERAL"
    " (SELECT map_id, ordinal, x, y, yaw, covariance FROM enfilade.link_point_anchors"
    "   WHERE site_id = $1 AND link_point_id = p.link_point_id OFFSET 0) a"
    " WHERE p.site_id = $1 AND " ENFILADE_IS_CHANGED("p.changed_version") " ORDER BY p.link_point_id, a.ordinal"};
constexpr Statement kSelectRemovals{"reading removals from the graph",
                                    "SELECT kind, id FROM enfilade.graph_removals"
                                    " WHERE site_id = $1 AND removed_version > $2 ORDER BY kind, id"};
constexpr int kAttempts = 3;

struct GraphRead {
  GraphChanges changes;
  // Not if the site was created again since, or what was removed since is forgotten.
  bool whole = false;
};

struct GraphMapRow {
  GraphMap map;
  std::string outline;
};

GraphMapRow ReadGraphMapRow(Row& row) {
  GraphMapRow out;
  out.map.id = MapId(std::string(row.Text()));
  out.map.display_name = row.Text();
  out.map.level = row.Int32();
  out.map.environment = static_cast<Environment>(row.Int16());
  out.outline = row.OptionalBytes().value_or("");
  const bool placed = row.Bool();
  PoseWithCovariance place;
  place.pose = {row.Double(), row.Double(), row.Double()};
  place.covariance = ReadCovariance(row);
  if (placed) out.map.T_world_map = place;
  out.map.graph_version = row.Int64();
  return out;
}

absl::Status ReadRowsInto(const Result& maps, const Result& link_points, const Result& removals,
                          GraphChanges& changes) {
  ENFILADE_ASSIGN_OR_RETURN(std::vector<GraphMapRow> rows, ReadRows(maps, ReadGraphMapRow));
  for (GraphMapRow& row : rows) {
    if (!row.outline.empty()) {
      ENFILADE_ASSIGN_OR_RETURN(row.map.outline, DecodePolygon(row.outline));
    }
    changes.maps.push_back(std::move(row.map));
  }
  ENFILADE_ASSIGN_OR_RETURN(changes.link_points, ReadLinkPoints(link_points));
  if (changes.complete) return absl::OkStatus();
  for (int i = 0; i < removals.rows(); ++i) {
    Row row(removals, i);
    const bool is_map = row.Int16() == 1;
    std::string id(row.Text());
    ENFILADE_RETURN_IF_ERROR(row.status());
    if (is_map) {
      changes.removed_maps.emplace_back(std::move(id));
    } else {
      changes.removed_link_points.emplace_back(std::move(id));
    }
  }
  return absl::OkStatus();
}

void QueueChanges(Transaction& transaction, const SiteId& site, std::int64_t since) {
  transaction.Queue(kSelectGraph, Params(site));
  if (since == 0) {
    transaction.Queue(kSelectMaps, Params(site));
    transaction.Queue(kSelectLinkPoints, Params(site));
  } else {
    transaction.Queue(kSelectChangedMaps, Params(site, since));
    transaction.Queue(kSelectChangedLinkPoints, Params(site, since));
  }
  transaction.Queue(kSelectRemovals, Params(site, since));
  transaction.Queue(kSelectGraph, Params(site));
}

// Of what QueueChanges has queued. Each statement sees what was committed before it. If the version is the same before
// and after the other statements, all of them saw that version; unset otherwise.
absl::StatusOr<std::optional<GraphRead>> ReadQueued(std::span<const Result> results, const SiteId& site,
                                                    std::int64_t since) {
  GraphRead read;
  GraphChanges& changes = read.changes;
  std::int64_t after = 0;
  std::int64_t forgotten = 0;
  for (const Result* result : {&results[4], &results[0]}) {
    if (result->rows() == 0) return NotFound("{} does not exist", NameOf(site));
    Row row(*result, 0);
    changes.version = row.Int64();
    changes.root = MapId(std::string(row.OptionalText().value_or("")));
    forgotten = std::max(forgotten, row.Int64());
    ENFILADE_RETURN_IF_ERROR(row.status());
    if (result == &results[4]) after = changes.version;
  }
  if (after != changes.version) return std::nullopt;
  read.whole = since == 0 || (since <= changes.version && since >= forgotten);
  changes.complete = since == 0;
  ENFILADE_RETURN_IF_ERROR(ReadRowsInto(results[1], results[2], results[3], changes));
  return read;
}

absl::StatusOr<std::optional<GraphRead>> TryRead(Pool& pool, const CallContext& context, const SiteId& site,
                                                 std::int64_t since, bool lock) {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool, context));
  if (lock) transaction.Queue(kShareGraph, Params(site));
  QueueChanges(transaction, site, since);
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.FlushAndCommit());
  return ReadQueued(std::span(results).subspan(lock ? 1 : 0), site, since);
}

}  // namespace

absl::StatusOr<GraphChanges> ReadGraphChanges(Pool& pool, const CallContext& context, const SiteId& site,
                                              std::int64_t since) {
  for (int attempt = 1; attempt <= kAttempts; ++attempt) {
    ENFILADE_ASSIGN_OR_RETURN(auto read, TryRead(pool, context, site, since, attempt == kAttempts));
    if (read && !read->whole) return ReadGraphChanges(pool, context, site, 0);
    if (read) return std::move(read->changes);
  }
  return Aborted("{} was deleted and created again during the call: try again", NameOf(site));
}

absl::StatusOr<GraphChanges> ReadLockedGraph(Transaction& transaction, const SiteId& site, std::int64_t since) {
  QueueChanges(transaction, site, since);
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.Flush());
  ENFILADE_ASSIGN_OR_RETURN(auto read, ReadQueued(results, site, since));
  if (!read) return Internal("the graph of {} changed while it was locked", NameOf(site));
  if (!read->whole) return ReadLockedGraph(transaction, site, 0);
  return std::move(read->changes);
}

}  // namespace enfilade::storage::postgres
