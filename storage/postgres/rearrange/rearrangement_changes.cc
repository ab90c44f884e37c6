// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/rearrange/rearrangement_changes.h"

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/resource_name.h"
#include "storage/postgres/driver/etag.h"
#include "storage/postgres/driver/pose_columns.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/graph/link_point_changes.h"
#include "storage/postgres/graph/link_point_rows.h"
#include "storage/postgres/graph/placement.h"
#include "storage/postgres/maps/layer_rows.h"
#include "storage/postgres/maps/map_edit_rows.h"
#include "storage/postgres/maps/numbered_map.h"
#include "storage/postgres/maps/revision_rows.h"
#include "storage/postgres/rearrange/rearrangement_rows.h"

namespace enfilade::storage::postgres {
namespace {

constexpr Statement kSelectSourcePlaces{
    "reading the places of the maps that are left",
    "SELECT DISTINCT ON (p.target) p.target, g.x, g.y, g.yaw, g.covariance, p.x, p.y, p.yaw"
    " FROM enfilade.rearrangement_parts n JOIN enfilade.rearrangement_parts p ON p.site_id = n.site_id"
    "   AND p.rearrangement_id = n.rearrangement_id AND p.kind = 3 AND p.target = n.subject"
    " JOIN enfilade.graph_maps g ON g.site_id = p.site_id AND g.map_id = p.source"
    " WHERE n.site_id = $1 AND n.rearrangement_id = $2 AND n.kind = 1 AND g.x IS NOT NULL"
    " ORDER BY p.target, p.ordinal"};

// T_target_x of what was T_source_x, by the part `p`.
#define ENFILADE_MOVED_X "p.x + cos(p.yaw) * t.x - sin(p.yaw) * t.y"
#define ENFILADE_MOVED_Y "p.y + sin(p.yaw) * t.x + cos(p.yaw) * t.y"
#define ENFILADE_MOVED_POSE                         \
  "x = " ENFILADE_MOVED_X ", y = " ENFILADE_MOVED_Y \
  ","                                               \
  " yaw = enfilade.wrap_angle(t.yaw + p.yaw)"
#define ENFILADE_OF_SESSIONS                                                                             \
  " FROM enfilade.rearrangement_parts p WHERE p.site_id = $1 AND p.rearrangement_id = $2 AND p.kind = 3" \
  " AND t.site_id = $1 AND t.session_id = p.subject"
#define ENFILADE_OF_REDIRECTS                                                                            \
  " FROM enfilade.rearrangement_parts p WHERE p.site_id = $1 AND p.rearrangement_id = $2 AND p.kind = 6" \
  " AND t.site_id = $1 AND t.map_id = p.subject"

constexpr Statement kMoveVerdicts{"moving verdicts",
                                  "UPDATE enfilade.door_verdicts t SET map_id = p.target, " ENFILADE_MOVED_POSE
                                  ", covariance = enfilade.rotate_covariance(t.covariance, p.yaw)"
                                  " FROM enfilade.rearrangement_parts p JOIN enfilade.sessions s ON s.site_id = "
                                  "p.site_id AND s.session_id = p.subject"
                                  " WHERE p.site_id = $1 AND p.rearrangement_id = $2 AND p.kind = 3 AND t.site_id = $1"
                                  " AND t.session_id = s.previous_session_id AND t.map_id = p.source"};
constexpr Statement kRedirectVerdicts{
    "moving verdicts into maps that disappear",
    "UPDATE enfilade.door_verdicts t SET map_id = p.target, " ENFILADE_MOVED_POSE
    ", covariance = enfilade.rotate_covariance(t.covariance, p.yaw)" ENFILADE_OF_REDIRECTS};
constexpr Statement kMoveSessions{
    "moving the sessions",
    "UPDATE enfilade.sessions t SET map_id = p.target,"
    " initial_x = p.x + cos(p.yaw) * t.initial_x - sin(p.yaw) * t.initial_y,"
    " initial_y = p.y + sin(p.yaw) * t.initial_x + cos(p.yaw) * t.initial_y,"
    " initial_yaw = enfilade.wrap_angle(t.initial_yaw + p.yaw),"
    " initial_covariance = enfilade.rotate_covariance(t.initial_covariance, p.yaw)" ENFILADE_OF_SESSIONS};
constexpr Statement kMoveSubmaps{"moving submaps",
                                 "UPDATE enfilade.slam_submaps t SET " ENFILADE_MOVED_POSE ENFILADE_OF_SESSIONS};
constexpr Statement kMoveNodes{"moving keyframes",
                               "UPDATE enfilade.slam_nodes t SET " ENFILADE_MOVED_POSE
                               ", covariance = enfilade.rotate_covariance(t.covariance, p.yaw)" ENFILADE_OF_SESSIONS};
constexpr Statement kMoveTracks{
    "moving tracks",
    "UPDATE enfilade.session_tracks t SET map_id = p.target,"
    " track = ST_Affine(t.track, cos(p.yaw), -sin(p.yaw), sin(p.yaw), cos(p.yaw), p.x, p.y)" ENFILADE_OF_SESSIONS};
#define ENFILADE_MOVE_ROBOT_POSES                                                           \
  "UPDATE enfilade.robot_poses t SET map_id = p.target,"                                    \
  " point = ST_Affine(t.point, cos(p.yaw), -sin(p.yaw), sin(p.yaw), cos(p.yaw), p.x, p.y)," \
  " yaw = enfilade.wrap_angle(t.yaw + p.yaw),"                                              \
  " covariance = enfilade.rotate_covariance(t.covariance, p.yaw), version = $3"
constexpr Statement kMoveRobotPoses{"moving robots' poses",
                                    ENFILADE_MOVE_ROBOT_POSES ENFILADE_OF_SESSIONS " AND t.map_id = p.source"};
constexpr Statement kRedirectRobotPoses{"moving robots' poses in maps that disappear",
                                        ENFILADE_MOVE_ROBOT_POSES ENFILADE_OF_REDIRECTS};
constexpr Statement kRedirectControlPoints{"moving control points",
                                           "UPDATE enfilade.control_points t SET map_id = p.target,"
                                           " x = " ENFILADE_MOVED_X ", y = " ENFILADE_MOVED_Y ENFILADE_OF_REDIRECTS};

constexpr Statement kDropLeavingLayers{
    "removing layers",
    "DELETE FROM enfilade.map_layers l USING enfilade.rearrangement_parts p WHERE p.site_id = $1"
    " AND p.rearrangement_id = $2 AND p.kind IN (2, 3) AND l.site_id = $1 AND l.map_id = p.source AND l.session_id = "
    "p.subject"
    " AND NOT EXISTS (SELECT FROM enfilade.rearrangement_parts r WHERE r.site_id = $1 AND r.rearrangement_id = $2"
    "   AND r.kind = 6 AND r.subject = l.map_id)"};
constexpr Statement kRedirectMaps{"redirecting the maps",
                                  "UPDATE enfilade.maps t SET redirect_map_id = p.target, redirect_x = p.x,"
                                  " redirect_y = p.y, redirect_yaw = p.yaw" ENFILADE_OF_REDIRECTS};
constexpr Statement kTakeMapsFromGraph{
    "taking the maps from the graph",
    "DELETE FROM enfilade.graph_maps t USING enfilade.rearrangement_parts p WHERE p.site_id = $1"
    " AND p.rearrangement_id = $2 AND p.kind = 6 AND t.site_id = $1 AND t.map_id = p.subject"};
constexpr Statement kRecordRemovals{
    "recording removals",
    "INSERT INTO enfilade.graph_removals (site_id, kind, id, removed_version)"
    " SELECT g.site_id, CASE p.kind WHEN 6 THEN 1 ELSE 2 END, p.subject, g.graph_version"
    " FROM enfilade.site_graphs g JOIN enfilade.rearrangement_parts p USING (site_id)"
    " WHERE g.site_id = $1 AND p.rearrangement_id = $2 AND p.kind IN (5, 6)"
    " ON CONFLICT (site_id, kind, id) DO UPDATE SET removed_version = excluded.removed_version"};
constexpr Statement kPinMaps{
    "pinning the maps",
    "UPDATE enfilade.maps t SET pinned = true, etag = $3, update_time = now() FROM ("
    "  SELECT DISTINCT unnest(ARRAY[source, CASE WHEN kind <> 2 THEN target END])::text AS map_id"
    "  FROM enfilade.rearrangement_parts WHERE site_id = $1 AND rearrangement_id = $2 AND kind IN (2, 3, 6)) p"
    " WHERE t.site_id = $1 AND t.map_id = p.map_id AND t.redirect_map_id IS NULL AND NOT t.pinned"};

}  // namespace

absl::Status AddMaps(Transaction& transaction, const SiteId& site, const RearrangementChange& change,
                     std::int64_t version) {
  if (change.rearrangement.new_maps.empty()) return absl::OkStatus();
  for (const rearrange::MapSeed& map : change.rearrangement.new_maps) QueueNumberedMap(transaction, site, map);
  ENFILADE_ASSIGN_OR_RETURN(const Result places, transaction.Execute(kSelectSourcePlaces, Params(site, change.id)));
  std::vector<MapPose> poses;
  for (int i = 0; i < places.rows(); ++i) {
    Row row(places, i);
    MapPose pose;
    pose.map = MapId(std::string(row.Text()));
    PoseWithCovariance T_world_from;
    T_world_from.pose = ReadPose(row);
    T_world_from.covariance = ReadCovariance(row);
    const Pose2 T_to_from = ReadPose(row);
    ENFILADE_RETURN_IF_ERROR(row.status());
    pose.T_world_map = Compose(T_world_from, {Inverse(T_to_from), Eigen::Matrix3d::Zero()});
    poses.push_back(pose);
  }
  QueuePlaces(transaction, site, version, poses, {});
  return absl::OkStatus();
}

void QueueMoves(Transaction& transaction, const SiteId& site, const rearrange::RearrangementId& id) {
  const Params key(site, id);
  QueueAreaMoves(transaction, site, id);
  for (const Statement* statement : {&kMoveVerdicts, &kRedirectVerdicts, &kMoveSessions, &kMoveSubmaps, &kMoveNodes,
                                     &kMoveTracks, &kRedirectControlPoints}) {
    transaction.Queue(*statement, key);
  }
  transaction.Queue(kMoveRobotPoses, Params(site, id, NewEtag()));
  transaction.Queue(kRedirectRobotPoses, Params(site, id, NewEtag()));
}

absl::Status ChangeRasters(Transaction& transaction, const SiteId& site, const RearrangementChange& change) {
  for (const SeenLayers& seen : change.seen) {
    ENFILADE_RETURN_IF_ERROR(CheckLayers(transaction, {site, seen.map}, seen.version));
  }
  for (const RearrangedRaster& raster : change.rasters) {
    if (!raster.revision) continue;
    NewRevision revision = *raster.revision;
    revision.layers_version = raster.layers_version;
    const auto stored = StoreRevision(transaction, {site, raster.map}, revision, {}, MapState::kReady);
    if (!stored.ok()) return ExplainRevisionError(stored.status(), site, raster.map);
    for (const AdoptedPublication& adopted : raster.adopted) {
      ENFILADE_RETURN_IF_ERROR(AdoptPublication(transaction, adopted, *stored));
    }
  }
  for (const RearrangedRaster& raster : change.rasters) QueueLayersChange(transaction, {site, raster.map});
  transaction.Queue(kDropLeavingLayers, Params(site, change.id));
  for (const RearrangedRaster& raster : change.rasters) {
    for (const EnteringLayer& layer : raster.entering) {
      QueueTopLayer(transaction, {site, raster.map}, layer.session, layer.raster);
    }
  }
  return absl::OkStatus();
}

void QueueRedirects(Transaction& transaction, const SiteId& site, const rearrange::RearrangementId& id) {
  transaction.Queue(kRedirectMaps, Params(site, id));
  transaction.Queue(kTakeMapsFromGraph, Params(site, id));
  transaction.Queue(kRecordRemovals, Params(site, id));
}

void QueuePins(Transaction& transaction, const SiteId& site, const rearrange::RearrangementId& id) {
  transaction.Queue(kPinMaps, Params(site, id, NewEtag()));
}

}  // namespace enfilade::storage::postgres
