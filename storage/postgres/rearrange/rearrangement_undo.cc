// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/rearrange/rearrangement_undo.h"

#include <string>

#include "core/base/resource_name.h"
#include "storage/graph/rearrangement_rules.h"
#include "storage/postgres/driver/etag.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/rearrange/rearrangement_rows.h"
#include "storage/postgres/rearrange/session_cuts.h"

namespace enfilade::storage::postgres {
namespace {

constexpr Statement kLockUndone{"locking the rearrangement",
                                "SELECT version_undone, undo_expired FROM enfilade.rearrangements"
                                " WHERE site_id = $1 AND rearrangement_id = $2 FOR UPDATE"};
constexpr Statement kLockUndoneMaps{
    "locking the maps",
    "SELECT FROM enfilade.maps WHERE site_id = $1 AND map_id IN (SELECT key FROM enfilade.rearrangement_images"
    "  WHERE site_id = $1 AND rearrangement_id = $2 AND relation = 'map') ORDER BY map_id FOR UPDATE"};
constexpr Statement kLockUndoneSessions{
    "locking the sessions",
    "SELECT FROM enfilade.sessions WHERE site_id = $1 AND session_id IN (SELECT key FROM enfilade.rearrangement_images"
    "  WHERE site_id = $1 AND rearrangement_id = $2 AND relation = 'session') ORDER BY session_id FOR UPDATE"};
constexpr Statement kFindChanged{
    "looking for later changes",
    "SELECT relation, key FROM enfilade.rearrangement_images WHERE site_id = $1 AND rearrangement_id = $2"
    " AND relation NOT IN ('place', 'robot_pose')"
    " AND after IS DISTINCT FROM enfilade.rearrangement_image(site_id, relation, key) ORDER BY relation, key LIMIT 1"};
// Sessions, link points and areas that have come into the maps that would disappear.
constexpr Statement kFindNewcomer{
    "looking for what came later",
    "SELECT 'session ' || s.session_id, p.subject FROM enfilade.rearrangement_parts p JOIN enfilade.sessions s"
    "   ON s.site_id = p.site_id AND s.map_id = p.subject AND s.delete_time IS NULL"
    " WHERE p.site_id = $1 AND p.rearrangement_id = $2 AND p.kind = 1 AND NOT EXISTS ("
    "  SELECT FROM enfilade.rearrangement_parts m WHERE m.site_id = $1 AND m.rearrangement_id = $2 AND m.kind = 3"
    "  AND m.subject = s.session_id)"
    " UNION ALL SELECT 'link point ' || a.link_point_id, p.subject FROM enfilade.rearrangement_parts p"
    " JOIN enfilade.link_point_anchors a ON a.site_id = p.site_id AND a.map_id = p.subject"
    " WHERE p.site_id = $1 AND p.rearrangement_id = $2 AND p.kind = 1 AND NOT EXISTS ("
    "  SELECT FROM enfilade.rearrangement_parts m WHERE m.site_id = $1 AND m.rearrangement_id = $2"
    "  AND m.kind IN (4, 5) AND m.subject = a.link_point_id)"
    " UNION ALL SELECT 'area ' || a.area_id, p.subject FROM enfilade.rearrangement_parts p"
    " JOIN enfilade.map_areas a ON a.site_id = p.site_id AND a.map_id = p.subject"
    " WHERE p.site_id = $1 AND p.rearrangement_id = $2 AND p.kind = 1 AND NOT EXISTS ("
    "  SELECT FROM enfilade.rearrangement_images i WHERE i.site_id = $1 AND i.rearrangement_id = $2"
    "  AND i.relation = 'area' AND i.key = a.map_id || '/' || a.area_id) ORDER BY 1 LIMIT 1"};

// Images that are restored: "r" is the row of rearrangement_images.
#define ENFILADE_IMAGES(relation) \
  "enfilade.rearrangement_images r WHERE r.site_id = $1 AND r.rearrangement_id = $2 AND r.relation = '" relation "'"

constexpr Statement kRestoreMaps{
    "restoring the maps",
    "UPDATE enfilade.maps m SET redirect_map_id = NULL, redirect_x = NULL, redirect_y = NULL, redirect_yaw = NULL"
    " FROM enfilade.rearrangement_parts p WHERE p.site_id = $1 AND p.rearrangement_id = $2 AND p.kind = 6"
    " AND m.site_id = $1 AND m.map_id = p.subject"};
// In its former place, unless the map that it became a part of has been moved since: then beside it.
constexpr Statement kRestorePlaces{
    "restoring the maps' places",
    "INSERT INTO enfilade.graph_maps (site_id, map_id, changed_version, x, y, yaw, covariance)"
    " SELECT $1, p.subject, $3, CASE WHEN v.same THEN b.x ELSE t.x + cos(t.yaw) * p.x - sin(t.yaw) * p.y END,"
    "   CASE WHEN v.same THEN b.y ELSE t.y + sin(t.yaw) * p.x + cos(t.yaw) * p.y END,"
    "   CASE WHEN v.same THEN b.yaw ELSE enfilade.wrap_angle(t.yaw + p.yaw) END,"
    "   CASE WHEN v.same THEN b.covariance ELSE t.covariance END"
    " FROM enfilade.rearrangement_parts p JOIN enfilade.graph_maps t ON t.site_id = $1 AND t.map_id = p.target"
    " JOIN enfilade.rearrangement_images i ON i.site_id = $1 AND i.rearrangement_id = $2 AND i.relation = 'place'"
    "   AND i.key = p.subject"
    " LEFT JOIN enfilade.rearrangement_images j ON j.site_id = $1 AND j.rearrangement_id = $2 AND j.relation = 'place'"
    "   AND j.key = p.target"
    " CROSS JOIN LATERAL (SELECT t.x IS NULL OR coalesce(j.before"
    "   = enfilade.rearrangement_image($1, 'place', p.target), false) AS same) v"
    " CROSS JOIN LATERAL jsonb_populate_record(NULL::enfilade.graph_maps, i.before) b"
    " WHERE p.site_id = $1 AND p.rearrangement_id = $2 AND p.kind = 6"};
constexpr Statement kForgetRemovals{
    "restoring what was removed",
    "DELETE FROM enfilade.graph_removals g USING enfilade.rearrangement_parts p WHERE p.site_id = $1"
    " AND p.rearrangement_id = $2 AND p.kind IN (5, 6) AND g.site_id = $1"
    " AND g.kind = CASE p.kind WHEN 6 THEN 1 ELSE 2 END AND g.id = p.subject"};
constexpr Statement kDropAnchorsOf{
    "removing anchors",
    "DELETE FROM enfilade.link_point_anchors t USING enfilade.rearrangement_parts p WHERE p.site_id = $1"
    " AND p.rearrangement_id = $2 AND p.kind IN (4, 5) AND t.site_id = $1 AND t.link_point_id = p.subject"};
constexpr Statement kDropNewLinkPoints{
    "removing new link points",
    "WITH gone AS (DELETE FROM enfilade.link_points t USING " ENFILADE_IMAGES("link_point")
    " AND r.before IS NULL AND t.site_id = $1 AND t.link_point_id = r.key RETURNING t.link_point_id)"
    " INSERT INTO enfilade.graph_removals (site_id, kind, id, removed_version) SELECT $1, 2, link_point_id, $3 FROM gone"
    " ON CONFLICT (site_id, kind, id) DO UPDATE SET removed_version = excluded.removed_version"};
constexpr Statement kRestoreLinkPoints{
    "restoring link points",
    "INSERT INTO enfilade.link_points (site_id, link_point_id, kind, tag, direction_map_id, difficulty, environment,"
    " state, valid_until, \"use\", forced, pinned, changed_version, request_id,"
    " request_sha256, create_time) SELECT b.site_id, b.link_point_id, b.kind, b.tag, b.direction_map_id, b.difficulty, "
    "b.environment, b.state,"
    "   b.valid_until, b.\"use\", b.forced, coalesce(b.pinned, false), $3, b.request_id,"
    "   b.request_sha256, b.create_time"
    " FROM enfilade.rearrangement_images r,"
    "   jsonb_populate_record(NULL::enfilade.link_points, r.before -> 'link_point') b"
    " WHERE r.site_id = $1 AND r.rearrangement_id = $2 AND r.relation = 'link_point' AND r.before IS NOT NULL"
    " ON CONFLICT (site_id, link_point_id) DO UPDATE SET kind = excluded.kind,"
    " direction_map_id = excluded.direction_map_id, position = NULL, yaw = NULL, world_covariance = NULL,"
    " changed_version = excluded.changed_version, etag = excluded.etag, update_time = excluded.update_time"};
constexpr Statement kRestoreAnchors{
    "restoring anchors",
    "INSERT INTO enfilade.link_point_anchors (site_id, link_point_id, map_id, ordinal, x, y, yaw, covariance)"
    " SELECT b.site_id, b.link_point_id, b.map_id, b.ordinal, b.x, b.y, b.yaw, b.covariance"
    " FROM enfilade.rearrangement_images r, jsonb_array_elements(r.before -> 'anchors') e,"
    "   jsonb_populate_record(NULL::enfilade.link_point_anchors, e) b"
    " WHERE r.site_id = $1 AND r.rearrangement_id = $2 AND r.relation = 'link_point' AND r.before IS NOT NULL"
    " ORDER BY b.link_point_id, b.ordinal"};
constexpr Statement kRestoreEvidence{
    "restoring evidence",
    "INSERT INTO enfilade.link_point_evidence"
    " (site_id, link_point_id, map_id, kind, encoding, sha256, time_ns, ordinal, x, y, yaw)"
    " SELECT b.site_id, b.link_point_id, b.map_id, b.kind, b.encoding, b.sha256, b.time_ns, b.ordinal, b.x, b.y, b.yaw"
    " FROM enfilade.rearrangement_images r, jsonb_array_elements(nullif(r.before -> 'evidence', 'null')) e,"
    "   jsonb_populate_record(NULL::enfilade.link_point_evidence, e) b"
    " WHERE r.site_id = $1 AND r.rearrangement_id = $2 AND r.relation = 'link_point' AND r.before IS NOT NULL"};
constexpr Statement kRestoreSessions{
    "restoring the sessions",
    "UPDATE enfilade.sessions s SET map_id = b.map_id, initial_x = b.initial_x, initial_y = b.initial_y,"
    " initial_yaw = b.initial_yaw, initial_covariance = b.initial_covariance,"
    " acknowledged_sequence = b.acknowledged_sequence, highest_sequence = b.highest_sequence,"
    " recorded_sequence = b.recorded_sequence, laser_scans = b.laser_scans, odometry = b.odometry, images = b.images,"
    " point_clouds = b.point_clouds, withheld = b.withheld, door_reports = b.door_reports,"
    " payload_bytes = b.payload_bytes, last_time_ns = b.last_time_ns FROM enfilade.rearrangement_images r,"
    "   jsonb_populate_record(NULL::enfilade.sessions, r.before) b WHERE r.site_id = $1 AND r.rearrangement_id = $2"
    " AND r.relation = 'session' AND r.before IS NOT NULL AND s.site_id = $1 AND s.session_id = r.key"};
constexpr Statement kRestoreCheckpoints{
    "restoring checkpoints",
    "UPDATE enfilade.mapping_checkpoints s SET mapped_sequence = b.mapped_sequence, used = b.used,"
    " keyframes = b.keyframes FROM enfilade.rearrangement_images r,"
    "   jsonb_populate_record(NULL::enfilade.mapping_checkpoints, nullif(r.before -> 'checkpoint', 'null')) b"
    " WHERE r.site_id = $1 AND r.rearrangement_id = $2 AND r.relation = 'session' AND s.site_id = $1"
    " AND s.session_id = r.key AND b.mapped_sequence IS NOT NULL"};
constexpr Statement kRestoreSubmaps{
    "restoring submaps",
    "UPDATE enfilade.slam_submaps s SET x = b.x, y = b.y, yaw = b.t FROM enfilade.rearrangement_images r,"
    "   jsonb_to_recordset(nullif(r.before -> 'submaps', 'null')) AS b (i bigint, x float8, y float8, t float8)"
    " WHERE r.site_id = $1 AND r.rearrangement_id = $2 AND r.relation = 'slam' AND s.site_id = $1"
    " AND s.session_id = r.key AND s.submap_id = b.i"};
constexpr Statement kRestoreNodes{
    "restoring keyframes",
    "UPDATE enfilade.slam_nodes s SET x = b.x, y = b.y, yaw = b.t, covariance = b.c"
    " FROM enfilade.rearrangement_images r,"
    "   jsonb_to_recordset(nullif(r.before -> 'nodes', 'null')) AS b (i bigint, x float8, y float8, t float8, c "
    "float8[])"
    " WHERE r.site_id = $1 AND r.rearrangement_id = $2 AND r.relation = 'slam' AND s.site_id = $1"
    " AND s.session_id = r.key AND s.node_id = b.i"};
constexpr Statement kRestoreTracks{
    "restoring tracks",
    "INSERT INTO enfilade.session_tracks (site_id, session_id, map_id, track)"
    " SELECT $1, r.key, r.before #>> '{track,map_id}', (r.before #>> '{track,track}')::geometry"
    " FROM " ENFILADE_IMAGES("slam") " AND r.before #>> '{track,map_id}' IS NOT NULL"
    " ON CONFLICT (site_id, session_id) DO UPDATE SET map_id = excluded.map_id, track = excluded.track"};
constexpr Statement kRestoreVerdicts{
    "restoring verdicts",
    "UPDATE enfilade.door_verdicts v SET map_id = b.map_id, x = b.x, y = b.y, yaw = b.yaw, covariance = b.covariance"
    " FROM enfilade.rearrangement_images r, jsonb_populate_record(NULL::enfilade.door_verdicts, r.before) b"
    " WHERE r.site_id = $1 AND r.rearrangement_id = $2 AND r.relation = 'verdict' AND v.site_id = $1"
    " AND v.session_id = split_part(r.key, '/', 1) AND v.sequence = split_part(r.key, '/', 2)::bigint"};
constexpr Statement kRestoreControlPoints{
    "restoring control points",
    "UPDATE enfilade.control_points c SET map_id = b.map_id, x = b.x, y = b.y FROM enfilade.rearrangement_images r,"
    "   jsonb_array_elements(r.before) e, jsonb_populate_record(NULL::enfilade.control_points, e) b"
    " WHERE r.site_id = $1 AND r.rearrangement_id = $2 AND r.relation = 'control_points' AND c.site_id = $1"
    " AND c.ordinal = b.ordinal"};
constexpr Statement kRestoreRobotPoses{
    "restoring robots' poses",
    "UPDATE enfilade.robot_poses p SET map_id = b.map_id, session_id = b.session_id, point = b.point, yaw = b.yaw, "
    "covariance = b.covariance,"
    " version = $3 FROM enfilade.rearrangement_images r,"
    "   jsonb_populate_record(NULL::enfilade.robot_poses, r.before - 'point'"
    "     || jsonb_build_object('point', r.before ->> 'point')) b"
    " WHERE r.site_id = $1 AND r.rearrangement_id = $2 AND r.relation = 'robot_pose' AND p.site_id = $1"
    " AND p.robot_id = r.key AND (r.after ->> 'version')::bigint = p.version"};
// Robots that have reported since: with the session, or with the map that disappears. $3: as when restoring, so that
// what was restored stays.
constexpr Statement kReturnRobotPoses{
    "moving robots' poses back",
    "UPDATE enfilade.robot_poses t SET map_id = p.source,"
    " point = ST_Affine(t.point, cos(p.yaw), sin(p.yaw), -sin(p.yaw), cos(p.yaw),"
    "   -cos(p.yaw) * p.x - sin(p.yaw) * p.y, sin(p.yaw) * p.x - cos(p.yaw) * p.y),"
    " yaw = enfilade.wrap_angle(t.yaw - p.yaw), covariance = enfilade.rotate_covariance(t.covariance, -p.yaw),"
    " version = $3 FROM enfilade.rearrangement_parts p WHERE p.site_id = $1"
    " AND p.rearrangement_id = $2 AND p.kind = 3 AND t.site_id = $1 AND t.map_id = p.target AND t.version <> $3"
    " AND (t.session_id = p.subject OR p.target IN (SELECT subject FROM enfilade.rearrangement_parts"
    "   WHERE site_id = $1 AND rearrangement_id = $2 AND kind = 1))"};
constexpr Statement kRaiseLayersVersions{
    "raising the versions of layers",
    "INSERT INTO enfilade.map_layer_stacks AS s (site_id, map_id, version) SELECT $1, r.key, 1"
    " FROM enfilade.rearrangement_images r WHERE r.site_id = $1 AND r.rearrangement_id = $2"
    " AND r.relation = 'layers' AND r.before IS DISTINCT FROM r.after"
    " ON CONFLICT (site_id, map_id) DO UPDATE SET version = s.version + 1"};
constexpr Statement kForgetRunsOf{
    "forgetting runs of layers",
    "DELETE FROM enfilade.map_layer_runs l USING " ENFILADE_IMAGES(
        "layers") " AND r.before IS DISTINCT FROM r.after AND l.site_id = $1 AND l.map_id = r.key"};
constexpr Statement kDropLayersOf{
    "removing layers", "DELETE FROM enfilade.map_layers l USING " ENFILADE_IMAGES(
                           "layers") " AND r.before IS DISTINCT FROM r.after AND l.site_id = $1 AND l.map_id = r.key"};
constexpr Statement kRestoreLayers{
    "restoring layers",
    "INSERT INTO enfilade.map_layers (site_id, map_id, position, session_id, revision, raster_header, version,"
    " edit_version) SELECT b.site_id, b.map_id, b.position, b.session_id, b.revision, b.raster_header,"
    "   (SELECT s.version FROM enfilade.map_layer_stacks s WHERE s.site_id = $1 AND s.map_id = r.key),"
    "   coalesce(b.edit_version, 0)"
    " FROM enfilade.rearrangement_images r, jsonb_array_elements(nullif(r.before, 'null')) e,"
    "   jsonb_populate_record(NULL::enfilade.map_layers, e) b WHERE r.site_id = $1 AND r.rearrangement_id = $2"
    " AND r.relation = 'layers' AND r.before IS DISTINCT FROM r.after"};
constexpr Statement kRestoreLayerTiles{
    "restoring layers' tiles",
    "INSERT INTO enfilade.map_layer_tiles (site_id, map_id, position, tile_row, tile_column, sha256)"
    " SELECT $1, r.key, (e ->> 'position')::bigint, b.tile_row, b.tile_column, b.sha256"
    " FROM enfilade.rearrangement_images r, jsonb_array_elements(nullif(r.before, 'null')) e,"
    "   jsonb_populate_recordset(NULL::enfilade.map_layer_tiles, e -> 'tiles') b"
    " WHERE r.site_id = $1 AND r.rearrangement_id = $2 AND r.relation = 'layers'"
    " AND r.before IS DISTINCT FROM r.after"};
// The map's revision of before, under the next number: revisions are never taken back. While its parts are being
// stored, the next one has the same content, and is not current.
#define ENFILADE_RESTORED_REVISIONS                                                                     \
  "WITH m AS (SELECT r.key, (SELECT max(v.revision) FROM enfilade.map_revisions v WHERE v.site_id = $1" \
  "     AND v.map_id = r.key AND v.content_sha256 = (r.before ->> 'raster')::bytea"                     \
  "     AND v.revision <= t.current_revision) AS old,"                                                  \
  "     t.current_revision + 1 AS next"                                                                 \
  "   FROM enfilade.rearrangement_images r JOIN enfilade.maps t ON t.site_id = $1 AND t.map_id = r.key" \
  "   WHERE r.site_id = $1 AND r.rearrangement_id = $2 AND r.relation = 'map'"                          \
  "   AND r.before ->> 'raster' <> r.after ->> 'raster')"
constexpr Statement kRestoreRevisions{
    "restoring the maps' rasters", ENFILADE_RESTORED_REVISIONS
    " INSERT INTO enfilade.map_revisions (site_id, map_id, revision, source, session_id, resolution, origin_x, "
    "origin_y,"
    " origin_yaw, width, height, raster_header, content_sha256, tile_count, tile_bytes)"
    " SELECT v.site_id, v.map_id, m.next, v.source, v.session_id, v.resolution, v.origin_x, v.origin_y, v.origin_yaw,"
    "   v.width, v.height, v.raster_header, v.content_sha256, v.tile_count, v.tile_bytes"
    " FROM m JOIN enfilade.map_revisions v ON v.site_id = $1 AND v.map_id = m.key AND v.revision = m.old"};
constexpr Statement kRestoreRevisionTiles{
    "restoring the rasters' tiles", ENFILADE_RESTORED_REVISIONS
    " INSERT INTO enfilade.map_revision_tiles (site_id, map_id, revision, tile_row, tile_column, sha256)"
    " SELECT v.site_id, v.map_id, m.next, v.tile_row, v.tile_column, v.sha256"
    " FROM m JOIN enfilade.map_revision_tiles v ON v.site_id = $1 AND v.map_id = m.key AND v.revision = m.old"};
constexpr Statement kRestoreCurrentRevisions{
    "restoring the maps' rasters", ENFILADE_RESTORED_REVISIONS
    " UPDATE enfilade.maps t SET current_revision = m.next FROM m WHERE t.site_id = $1 AND t.map_id = m.key"};
// A map that began with the rearrangement leads back to where its sessions came from.
constexpr Statement kRedirectNewMaps{
    "redirecting the new maps",
    "UPDATE enfilade.maps t SET redirect_map_id = p.source, redirect_x = -cos(p.yaw) * p.x - sin(p.yaw) * p.y,"
    " redirect_y = sin(p.yaw) * p.x - cos(p.yaw) * p.y, redirect_yaw = -p.yaw"
    " FROM (SELECT DISTINCT ON (m.target) m.* FROM enfilade.rearrangement_parts n"
    "   JOIN enfilade.rearrangement_parts m ON m.site_id = n.site_id AND m.rearrangement_id = n.rearrangement_id"
    "   AND m.kind = 3 AND m.target = n.subject WHERE n.site_id = $1 AND n.rearrangement_id = $2 AND n.kind = 1"
    "   ORDER BY m.target, m.ordinal) p WHERE t.site_id = $1 AND t.map_id = p.target"};
constexpr Statement kTakeNewMaps{
    "taking the new maps from the graph",
    "WITH gone AS (DELETE FROM enfilade.graph_maps t USING enfilade.rearrangement_parts p WHERE p.site_id = $1"
    "   AND p.rearrangement_id = $2 AND p.kind = 1 AND t.site_id = $1 AND t.map_id = p.subject RETURNING t.map_id)"
    " INSERT INTO enfilade.graph_removals (site_id, kind, id, removed_version) SELECT $1, 1, map_id, $3 FROM gone"
    " ON CONFLICT (site_id, kind, id) DO UPDATE SET removed_version = excluded.removed_version"};
constexpr Statement kFindNotRestored{
    "checking what was restored",
    "SELECT relation, key FROM enfilade.rearrangement_images WHERE site_id = $1 AND rearrangement_id = $2"
    " AND relation NOT IN ('place', 'robot_pose', 'map')"
    " AND before IS DISTINCT FROM enfilade.rearrangement_image(site_id, relation, key)"
    " AND NOT (before IS NULL AND relation = 'layers') ORDER BY relation, key LIMIT 1"};
constexpr Statement kMarkUndone{"closing the rearrangement",
                                "UPDATE enfilade.rearrangements SET version_undone = $3, undo_time = now()"
                                " WHERE site_id = $1 AND rearrangement_id = $2"};

}  // namespace

absl::Status LockAndCheckUnchanged(Transaction& transaction, const SiteId& site, const StoredRearrangement& stored) {
  const std::string name = NameOfRearrangement(site, stored.id);
  const Params key(site, stored.id);
  ENFILADE_ASSIGN_OR_RETURN(const Result locked, transaction.Execute(kLockUndone, key));
  struct Undo {
    std::int64_t version = 0;  // 0: not undone
    bool expired = false;
  };
  ENFILADE_ASSIGN_OR_RETURN(const Undo undo, ReadOne(
                                                 locked,
                                                 [](Row& row) {
                                                   const std::int64_t version = row.Int64();
                                                   return Undo{version, row.Bool()};
                                                 },
                                                 name));
  if (undo.version != 0) return AlreadyUndone(name);
  if (undo.expired) return UndoExpired(name);
  transaction.Queue(kLockUndoneMaps, key);
  transaction.Queue(kLockUndoneSessions, key);
  ENFILADE_ASSIGN_OR_RETURN(const Result changed, transaction.Execute(kFindChanged, key));
  if (changed.rows() > 0) {
    Row row(changed, 0);
    const std::string relation(row.Text());
    return ChangedSince(name, relation, row.Text());
  }
  ENFILADE_ASSIGN_OR_RETURN(const Result newcomer, transaction.Execute(kFindNewcomer, key));
  if (newcomer.rows() > 0) {
    Row row(newcomer, 0);
    const std::string what(row.Text());
    return HasComeSince(name, what, MapId(std::string(row.Text())));
  }
  return absl::OkStatus();
}

absl::Status RestoreImages(Transaction& transaction, const SiteId& site, const rearrange::RearrangementId& id,
                           std::int64_t version) {
  const Params key(site, id);
  const Params with_version(site, id, version);
  transaction.Queue(kRestoreMaps, key);
  transaction.Queue(kRestorePlaces, with_version);
  transaction.Queue(kForgetRemovals, key);
  transaction.Queue(kDropAnchorsOf, key);
  transaction.Queue(kDropNewLinkPoints, with_version);
  transaction.Queue(kRestoreLinkPoints, with_version);
  QueueUncuts(transaction, site, id);
  QueueAreaReturns(transaction, site, id);
  for (const Statement* statement :
       {&kRestoreAnchors, &kRestoreEvidence, &kRestoreSessions, &kRestoreCheckpoints, &kRestoreSubmaps, &kRestoreNodes,
        &kRestoreTracks, &kRestoreVerdicts, &kRestoreControlPoints, &kRaiseLayersVersions, &kForgetRunsOf,
        &kDropLayersOf, &kRestoreLayers, &kRestoreLayerTiles, &kRestoreRevisions, &kRestoreRevisionTiles,
        &kRestoreCurrentRevisions, &kRedirectNewMaps}) {
    transaction.Queue(*statement, key);
  }
  const std::int64_t version_of_poses = NewEtag();
  for (const Statement* statement : {&kRestoreRobotPoses, &kReturnRobotPoses}) {
    transaction.Queue(*statement, Params(site, id, version_of_poses));
  }
  transaction.Queue(kTakeNewMaps, with_version);
  ENFILADE_RETURN_IF_ERROR(PlaceLinkPointsOf(transaction, site, id, version));
  ENFILADE_ASSIGN_OR_RETURN(const Result wrong, transaction.Execute(kFindNotRestored, key));
  if (wrong.rows() > 0) {
    Row row(wrong, 0);
    const std::string relation(row.Text());
    return Internal("{}: {} was not restored", NameOfRearrangement(site, id), DescribeImage(relation, row.Text()));
  }
  transaction.Queue(kMarkUndone, with_version);
  return absl::OkStatus();
}

}  // namespace enfilade::storage::postgres
