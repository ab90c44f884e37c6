// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/graph/graph_store.h"

#include "core/base/resource_name.h"
#include "storage/postgres/driver/etag.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/graph/graph_changes.h"
#include "storage/postgres/graph/graph_listener.h"
#include "storage/postgres/graph/graph_versions.h"
#include "storage/postgres/graph/link_point_rows.h"
#include "storage/postgres/graph/placement.h"

namespace enfilade::storage::postgres {
namespace {

constexpr Statement kSelectVersions{"reading the graphs' versions",
                                    "SELECT site_id, graph_version FROM enfilade.site_graphs WHERE site_id = ANY ($1)"};
constexpr Statement kUseLinkPoints{"switching link points",
                                   "UPDATE enfilade.link_points SET changed_version = $2,"
                                   " \"use\" = CASE WHEN link_point_id = ANY ($3) THEN 2 ELSE 1 END"
                                   " WHERE site_id = $1 AND ((\"use\" = 1 AND link_point_id = ANY ($3))"
                                   "   OR (\"use\" = 2 AND NOT link_point_id = ANY ($3)))"};
constexpr Statement kStoreResult{
    "storing the optimisation's result",
    "UPDATE enfilade.graph_versions SET chi2_before = $3, chi2_after = $4, switched_off = $5, map_count = $6,"
    " residual_count = $7 WHERE site_id = $1 AND version = $2"};
constexpr Statement kStorePoses{"storing maps' poses",
                                "INSERT INTO enfilade.map_poses (site_id, version, map_id, x, y, yaw, covariance)"
                                " SELECT site_id, $2, map_id, x, y, yaw, covariance FROM enfilade.graph_maps"
                                " WHERE site_id = $1 AND map_id = ANY ($3) AND x IS NOT NULL"};
constexpr Statement kUnposeMaps{"storing which maps have no pose any more",
                                "INSERT INTO enfilade.map_poses (site_id, version, map_id)"
                                " SELECT $1, $2, map_id FROM unnest($3::text[]) AS u (map_id)"};
constexpr Statement kUnposeOtherMaps{
    "storing which maps have no pose any more",
    "INSERT INTO enfilade.map_poses (site_id, version, map_id) SELECT $1, $2, map_id"
    " FROM (SELECT DISTINCT ON (map_id) map_id, x FROM enfilade.map_poses WHERE site_id = $1 AND version < $2"
    "   ORDER BY map_id, version DESC) last WHERE x IS NOT NULL AND map_id <> ALL ($3)"};
// Of the maps that the oldest optimisation which is kept poses, what it replaced.
constexpr Statement kForgetPoses{
    "deleting old poses",
    "WITH oldest AS (SELECT version FROM enfilade.graph_versions WHERE site_id = $1 AND cause = 7"
    "   ORDER BY version DESC OFFSET $2 LIMIT 1)"
    " DELETE FROM enfilade.map_poses p USING oldest o, enfilade.map_poses newer"
    " WHERE newer.site_id = $1 AND newer.version = o.version"
    "   AND p.site_id = $1 AND p.map_id = newer.map_id AND p.version < o.version"};
constexpr Statement kListVersions{
    "listing the graph's versions",
    "SELECT version, cause, resource, actor, create_time, chi2_before, chi2_after, switched_off, map_count,"
    " residual_count FROM enfilade.graph_versions WHERE site_id = $1 AND ($2 = 0 OR version < $2)"
    " ORDER BY version DESC LIMIT $3"};
constexpr Statement kLastOptimization{
    "looking for the last optimisation",
    "SELECT coalesce(max(version), 0) FROM enfilade.graph_versions WHERE site_id = $1 AND version > $2 AND cause = $3"};
// Two statements: see graph_changes.cc.
#define ENFILADE_SELECT_MAP_POSES                                                                                     \
  "SELECT DISTINCT ON (map_id) map_id, coalesce(x, 0), coalesce(y, 0), coalesce(yaw, 0), coalesce(covariance, '{}')," \
  " x IS NOT NULL FROM enfilade.map_poses WHERE site_id = $1 AND version <= $2"
constexpr Statement kSelectMapPoses{"reading maps' poses", ENFILADE_SELECT_MAP_POSES " ORDER BY map_id, version DESC"};
constexpr Statement kSelectChangedMapPoses{"reading maps' changed poses",
                                           ENFILADE_SELECT_MAP_POSES " AND version > $3 ORDER BY map_id, version DESC"};
constexpr Statement kIsKept{"looking for an optimisation",
                            "SELECT count(*) FROM (SELECT version FROM enfilade.graph_versions WHERE site_id = $1"
                            "   AND cause = 7 ORDER BY version DESC LIMIT $3) kept WHERE version = $2"};
constexpr Statement kSelectMapPlaces{"reading maps' places",
                                     "SELECT map_id, x, y, yaw, covariance FROM enfilade.graph_maps"
                                     " WHERE site_id = $1 AND (cardinality($2::text[]) = 0 OR map_id = ANY ($2))"
                                     " AND x IS NOT NULL ORDER BY map_id"};
constexpr Statement kDropControlPoints{"removing control points",
                                       "DELETE FROM enfilade.control_points WHERE site_id = $1"};
constexpr Statement kPutControlPoints{
    "storing control points",
    "INSERT INTO enfilade.control_points (site_id, ordinal, map_id, x, y, latitude, longitude)"
    " SELECT $1, u.n, u.map_id, u.x, u.y, u.latitude, u.longitude FROM"
    " unnest($2::text[], $3::float8[], $4::float8[], $5::float8[], $6::float8[])"
    " WITH ORDINALITY AS u (map_id, x, y, latitude, longitude, n)"};
constexpr Statement kSelectControlPoints{"reading control points",
                                         "SELECT map_id, x, y, latitude, longitude FROM enfilade.control_points"
                                         " WHERE site_id = $1 ORDER BY ordinal"};
constexpr Statement kSelectPlanTies{
    "reading the ties of prior maps",
    "SELECT f.prior_map_id, f.sha256, CASE WHEN f.sha256 = ANY ($2) THEN ''::bytea ELSE b.data END,"
    " coalesce(p.aligned_maps, '{}'), p.level"
    " FROM enfilade.prior_maps p JOIN enfilade.prior_map_files f USING (site_id, prior_map_id)"
    " JOIN enfilade.blobs b ON b.site_id = f.site_id AND b.sha256 = f.sha256"
    " WHERE p.site_id = $1 AND p.state = 3 AND f.product = 6 ORDER BY f.prior_map_id"};
constexpr Statement kDivergePlans{
    "storing which prior maps diverge",
    "UPDATE enfilade.prior_maps p SET state = 4, reason = u.reason, etag = u.etag, update_time = now()"
    " FROM unnest($2::text[], $3::text[], $4::bigint[]) AS u (prior_map_id, reason, etag)"
    " WHERE p.site_id = $1 AND p.prior_map_id = u.prior_map_id AND p.state = 3"};

MapPose ReadMapPose(Row& row) {
  MapPose pose;
  pose.map = MapId(std::string(row.Text()));
  pose.T_world_map.pose = {row.Double(), row.Double(), row.Double()};
  pose.T_world_map.covariance = ReadCovariance(row);
  return pose;
}

GraphVersion ReadVersion(Row& row) {
  GraphVersion version;
  version.version = row.Int64();
  version.cause = static_cast<GraphCause>(row.Int16());
  version.resource = row.Text();
  version.actor = row.Text();
  version.create_time = row.Time();
  GraphVersion::Optimization optimization;
  const std::optional<double> chi2_before = row.OptionalDouble();
  optimization.chi2_before = chi2_before.value_or(0.0);
  optimization.chi2_after = row.OptionalDouble().value_or(0.0);
  for (std::string& id : row.OptionalTexts()) optimization.switched_off.emplace_back(std::move(id));
  optimization.map_count = row.OptionalInt64().value_or(0);
  optimization.residual_count = row.OptionalInt64().value_or(0);
  if (chi2_before) version.optimization = std::move(optimization);
  return version;
}

absl::StatusOr<std::int64_t> LockExistingGraph(Transaction& transaction, const SiteId& site) {
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t version, LockGraph(transaction, site));
  if (version == 0) return NotFound("the graph of {} does not exist", NameOf(site));
  return version;
}

// Of a graph that `transaction` has locked.
absl::StatusOr<std::int64_t> StoreAndCommit(Transaction& transaction, const SiteId& site,
                                            const GraphSolution& solution) {
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t raised,
                            RaiseGraphVersion(transaction, site, GraphCause::kOptimized, ""));
  QueuePlaces(transaction, site, raised, solution.maps, solution.link_points);
  std::vector<std::string_view> switched_off, maps;
  for (const LinkPointId& id : solution.switched_off) switched_off.push_back(id.value());
  for (const MapPose& pose : solution.maps) maps.push_back(pose.map.value());
  transaction.Queue(kUseLinkPoints, Params(site, raised, switched_off));
  transaction.Queue(kStoreResult, Params(site, raised, solution.chi2_before, solution.chi2_after, switched_off,
                                         solution.map_count, solution.residual_count));
  transaction.Queue(kStorePoses, Params(site, raised, maps));
  if (!solution.contradicted_plans.empty()) {
    std::vector<std::string_view> plans, reasons;
    std::vector<std::int64_t> etags;
    for (const ContradictedPlan& plan : solution.contradicted_plans) {
      plans.push_back(plan.prior_map.value());
      reasons.push_back(plan.reason);
      etags.push_back(NewEtag());
    }
    transaction.Queue(kDivergePlans, Params(site, plans, reasons, etags));
  }
  if (solution.complete) {
    transaction.Queue(kUnposeOtherMaps, Params(site, raised, maps));
  } else {
    std::vector<std::string_view> unposed;
    for (const MapId& map : solution.unposed) unposed.push_back(map.value());
    transaction.Queue(kUnposeMaps, Params(site, raised, unposed));
  }
  transaction.Queue(kForgetPoses, Params(site, std::int64_t{GraphStore::kKeptOptimizations - 1}));
  ENFILADE_RETURN_IF_ERROR(WithContext(transaction.Commit(), NameOf(site)));
  return raised;
}

}  // namespace

absl::StatusOr<std::int64_t> GraphStore::GetVersion(const CallContext& context, const SiteId& site) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result, ExecuteAlone(pool_, context, kSelectGraphVersion, Params(site)));
  return ReadGraphVersion(result);
}

absl::StatusOr<GraphChanges> GraphStore::ReadChanges(const CallContext& context, const SiteId& site,
                                                     std::int64_t since) const {
  return ReadGraphChanges(pool_, context, site, since);
}

absl::StatusOr<std::int64_t> GraphStore::Apply(const CallContext& context, const SiteId& site, std::int64_t version,
                                               const GraphSolution& solution) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t present, LockExistingGraph(transaction, site));
  if (present != version) {
    return Aborted("the graph of {} is at version {}, no longer at {}: optimise it again", NameOf(site), present,
                   version);
  }
  return StoreAndCommit(transaction, site, solution);
}

absl::StatusOr<std::int64_t> GraphStore::SolveHeld(
    const CallContext& context, const SiteId& site, std::int64_t since,
    const std::function<absl::StatusOr<GraphSolution>(const GraphChanges&)>& solve) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_RETURN_IF_ERROR(LockExistingGraph(transaction, site).status());
  ENFILADE_ASSIGN_OR_RETURN(const GraphChanges changes, ReadLockedGraph(transaction, site, since));
  ENFILADE_ASSIGN_OR_RETURN(const GraphSolution solution, solve(changes));
  return StoreAndCommit(transaction, site, solution);
}

absl::StatusOr<std::vector<GraphVersion>> GraphStore::ListVersions(const CallContext& context, const SiteId& site,
                                                                   std::int64_t before, int limit) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result,
                            ExecuteAlone(pool_, context, kListVersions, Params(site, before, std::int64_t{limit})));
  return ReadRows(result, ReadVersion);
}

absl::StatusOr<std::int64_t> GraphStore::FindLastOptimization(const CallContext& context, const SiteId& site,
                                                              std::int64_t since) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result,
                            ExecuteAlone(pool_, context, kLastOptimization,
                                         Params(site, since, static_cast<std::int16_t>(GraphCause::kOptimized))));
  return ReadOne(
      result, [](Row& row) { return row.Int64(); }, NameOf(site));
}

absl::StatusOr<MapPoseChanges> GraphStore::GetMapPoses(const CallContext& context, const SiteId& site,
                                                       std::int64_t version, std::int64_t since) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  if (since == 0) {
    transaction.Queue(kSelectMapPoses, Params(site, version));
  } else {
    transaction.Queue(kSelectChangedMapPoses, Params(site, version, since));
  }
  // Afterwards: a version that is still kept has lost nothing.
  transaction.Queue(kIsKept, Params(site, version, std::int64_t{kKeptOptimizations}));
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.FlushAndCommit());
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t kept,
                            ReadOne(
                                results[1], [](Row& row) { return row.Int64(); }, NameOf(site)));
  MapPoseChanges changes;
  for (int i = 0; i < results[0].rows(); ++i) {
    Row row(results[0], i);
    MapPose pose = ReadMapPose(row);
    const bool posed = row.Bool();
    ENFILADE_RETURN_IF_ERROR(row.status());
    if (posed) {
      changes.posed.push_back(std::move(pose));
    } else if (since != 0) {
      changes.unposed.push_back(std::move(pose.map));
    }
  }
  if (kept == 0 || (since == 0 && changes.posed.empty())) {
    return NotFound("version {} of the graph of {} is not one of its last {} optimisations", version, NameOf(site),
                    kKeptOptimizations);
  }
  return changes;
}

absl::StatusOr<std::vector<MapPose>> GraphStore::GetPlaces(const CallContext& context, const SiteId& site,
                                                           const std::vector<MapId>& maps) const {
  std::vector<std::string_view> ids;
  for (const MapId& map : maps) ids.push_back(map.value());
  ENFILADE_ASSIGN_OR_RETURN(const auto result, ExecuteAlone(pool_, context, kSelectMapPlaces, Params(site, ids)));
  return ReadRows(result, ReadMapPose);
}

absl::StatusOr<std::int64_t> GraphStore::SetControlPoints(const CallContext& context, const SiteId& site,
                                                          const std::vector<ControlPoint>& points) const {
  std::vector<std::string_view> maps;
  std::vector<double> x, y, latitudes, longitudes;
  for (const ControlPoint& point : points) {
    maps.push_back(point.map.value());
    x.push_back(point.position.x());
    y.push_back(point.position.y());
    latitudes.push_back(point.latitude);
    longitudes.push_back(point.longitude);
  }
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t version,
                            RaiseGraphVersion(transaction, site, GraphCause::kGeoreferenced, ""));
  transaction.Queue(kDropControlPoints, Params(site));
  if (!points.empty()) transaction.Queue(kPutControlPoints, Params(site, maps, x, y, latitudes, longitudes));
  const absl::Status committed = transaction.Commit();
  if (SqlStateOf(committed) == "23503") {
    return NotFound("a map of the control points does not exist in {}", NameOf(site));
  }
  ENFILADE_RETURN_IF_ERROR(WithContext(committed, NameOf(site)));
  return version;
}

absl::StatusOr<std::vector<ControlPoint>> GraphStore::GetControlPoints(const CallContext& context,
                                                                       const SiteId& site) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result, ExecuteAlone(pool_, context, kSelectControlPoints, Params(site)));
  return ReadRows(result, [](Row& row) {
    ControlPoint point;
    point.map = MapId(std::string(row.Text()));
    point.position = {row.Double(), row.Double()};
    point.latitude = row.Double();
    point.longitude = row.Double();
    return point;
  });
}

absl::StatusOr<std::vector<StoredPlanTies>> GraphStore::ReadPlanTies(const CallContext& context, const SiteId& site,
                                                                     const std::vector<std::string>& known) const {
  std::vector<Bytes> digests;
  for (const std::string& sha256 : known) digests.push_back(Bytes{sha256});
  ENFILADE_ASSIGN_OR_RETURN(const auto result, ExecuteAlone(pool_, context, kSelectPlanTies, Params(site, digests)));
  return ReadRows(result, [](Row& row) {
    StoredPlanTies ties;
    ties.prior_map = PriorMapId(std::string(row.Text()));
    ties.sha256 = row.Bytes();
    ties.bytes = row.Bytes();
    for (std::string& map : row.OptionalTexts()) ties.maps.emplace_back(std::move(map));
    ties.level = row.Int32();
    return ties;
  });
}

absl::StatusOr<std::vector<storage::GraphListener::Change>> GraphStore::ListVersionsOf(
    const CallContext& context, const std::vector<SiteId>& sites) const {
  std::vector<std::string_view> ids;
  ids.reserve(sites.size());
  for (const SiteId& site : sites) ids.push_back(site.value());
  ENFILADE_ASSIGN_OR_RETURN(const auto result, ExecuteAlone(pool_, context, kSelectVersions, Params(ids)));
  return ReadRows(result, [](Row& row) {
    SiteId site{std::string(row.Text())};
    return storage::GraphListener::Change{std::move(site), row.Int64()};
  });
}

absl::StatusOr<std::unique_ptr<storage::GraphListener>> GraphStore::Listen(const CallContext& context) const {
  return GraphListener::Open(pool_, context);
}

}  // namespace enfilade::storage::postgres
