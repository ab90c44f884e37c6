// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/driver/etag.h"
#include "storage/postgres/rearrange/rearrangement_changes.h"
#include "storage/postgres/rearrange/rearrangement_undo.h"

namespace enfilade::storage::postgres {
namespace {

// Where areas go: into each map that gets keyframes from within 5 m of them, or else from nearest to them; `target` is
// their own map if such keyframes stay. The transform is that of the nearest keyframes' session: T_target_source.
// Keyframes are thinned out to one in each square of 2.5 m, so that thousands of areas take seconds. Distances are not
// looked at where there is one way only. A map without keyframes, which was imported, goes as a whole.
#define ENFILADE_AREAS_GO                                                                                              \
  "WITH moves AS (SELECT p.subject, p.target, p.x, p.y, p.yaw FROM enfilade.rearrangement_parts p"                     \
  "   WHERE p.site_id = $1 AND p.rearrangement_id = $2 AND p.kind = 3),"                                               \
  " redirects AS (SELECT p.subject, p.target, p.x, p.y, p.yaw FROM enfilade.rearrangement_parts p"                     \
  "   WHERE p.site_id = $1 AND p.rearrangement_id = $2 AND p.kind = 6),"                                               \
  " left_maps AS (SELECT p.source FROM enfilade.rearrangement_parts p"                                                 \
  "   WHERE p.site_id = $1 AND p.rearrangement_id = $2 AND p.kind IN (3, 6)),"                                         \
  " areas AS (SELECT a.* FROM enfilade.map_areas a"                                                                    \
  "   WHERE a.site_id = $1 AND a.map_id IN (SELECT source FROM left_maps)),"                                           \
  " seen AS MATERIALIZED (SELECT s.map_id, coalesce(m.target, s.map_id) AS target, coalesce(m.x, 0) AS x,"             \
  "     coalesce(m.y, 0) AS y, coalesce(m.yaw, 0) AS yaw,"                                                             \
  "     ST_Collect(DISTINCT ST_MakePoint(2.5 * round(n.x / 2.5), 2.5 * round(n.y / 2.5))) AS keyframes"                \
  "   FROM enfilade.sessions s JOIN enfilade.slam_nodes n ON n.site_id = $1 AND n.session_id = s.session_id"           \
  "   LEFT JOIN moves m ON m.subject = s.session_id"                                                                   \
  "   WHERE s.site_id = $1 AND s.delete_time IS NULL AND s.map_id IN (SELECT map_id FROM areas) GROUP BY 1, 2, 3, 4, " \
  "5),"                                                                                                                \
  " ways AS (SELECT map_id, count(*) AS count FROM seen GROUP BY map_id),"                                             \
  " near AS (SELECT DISTINCT ON (a.map_id, a.area_id, s.target) a.map_id, a.area_id, s.target, s.x, s.y, s.yaw,"       \
  "     CASE WHEN w.count = 1 THEN 0 ELSE ST_Distance(a.outline, s.keyframes) END AS distance"                         \
  "   FROM areas a JOIN seen s ON s.map_id = a.map_id JOIN ways w ON w.map_id = a.map_id"                              \
  "   ORDER BY a.map_id, a.area_id, s.target, distance),"                                                              \
  " nearest AS (SELECT n.*, min(n.distance) OVER (PARTITION BY n.map_id, n.area_id) AS least FROM near n),"            \
  " goes AS (SELECT map_id, area_id, target, x, y, yaw FROM nearest WHERE distance <= 5 OR distance = least"           \
  "   UNION ALL SELECT a.map_id, a.area_id, r.target, r.x, r.y, r.yaw FROM areas a"                                    \
  "     JOIN redirects r ON r.subject = a.map_id WHERE a.map_id NOT IN (SELECT map_id FROM ways))"

// An id that is taken in the other map gets the hash of its old name.
constexpr Statement kMoveAreas{
    "moving areas", ENFILADE_AREAS_GO
    ", come AS (INSERT INTO enfilade.map_areas (site_id, map_id, area_id, display_name, kind, outline, robot_types,"
    "     speed_limit, valid_from, valid_until, etag, create_time, update_time)"
    "   SELECT $1, g.target, CASE WHEN row_number() OVER (PARTITION BY g.target, g.area_id ORDER BY g.map_id) = 1"
    "       AND NOT EXISTS (SELECT FROM enfilade.map_areas t WHERE t.site_id = $1 AND t.map_id = g.target"
    "         AND t.area_id = g.area_id)"
    "     THEN g.area_id ELSE left(g.area_id, 46) || '-' || left(md5(g.map_id || '/' || g.area_id), 16) END,"
    "     a.display_name, a.kind,"
    "     ST_Affine(a.outline, cos(g.yaw), -sin(g.yaw), sin(g.yaw), cos(g.yaw), g.x, g.y), a.robot_types,"
    "     a.speed_limit, a.valid_from, a.valid_until, $3, a.create_time, a.update_time"
    "   FROM goes g JOIN areas a ON a.map_id = g.map_id AND a.area_id = g.area_id WHERE g.target <> g.map_id"
    "   RETURNING map_id, area_id),"
    " gone AS (DELETE FROM enfilade.map_areas t WHERE t.site_id = $1"
    "   AND (t.map_id, t.area_id) IN (SELECT map_id, area_id FROM goes)"
    "   AND (t.map_id, t.area_id) NOT IN (SELECT map_id, area_id FROM goes WHERE target = map_id)"
    "   RETURNING t.map_id, t.area_id, to_jsonb(t) || jsonb_build_object('outline', t.outline::text) AS before)"
    " INSERT INTO enfilade.rearrangement_images (site_id, rearrangement_id, relation, key, before)"
    " SELECT $1, $2, 'area', c.map_id || '/' || c.area_id, c.before"
    " FROM (SELECT map_id, area_id, NULL::jsonb AS before FROM come UNION ALL SELECT map_id, area_id, before FROM "
    "gone) c"};

#define ENFILADE_AREA_IMAGES \
  "enfilade.rearrangement_images r WHERE r.site_id = $1 AND r.rearrangement_id = $2 AND r.relation = 'area'"
constexpr Statement kDropMovedAreas{"removing areas",
                                    "DELETE FROM enfilade.map_areas t USING " ENFILADE_AREA_IMAGES
                                    " AND r.before IS NULL AND t.site_id = $1 AND t.map_id = split_part(r.key, '/', 1)"
                                    " AND t.area_id = split_part(r.key, '/', 2)"};
constexpr Statement kRestoreAreas{
    "restoring areas",
    "INSERT INTO enfilade.map_areas (site_id, map_id, area_id, display_name, kind, outline, robot_types, speed_limit,"
    " valid_from, valid_until, request_id, request_sha256, etag, create_time, update_time)"
    " SELECT $1, b.map_id, b.area_id, b.display_name, b.kind, b.outline, b.robot_types, b.speed_limit, b.valid_from,"
    "   b.valid_until, b.request_id, b.request_sha256, b.etag, b.create_time, b.update_time"
    " FROM enfilade.rearrangement_images r, jsonb_populate_record(NULL::enfilade.map_areas, r.before) b"
    " WHERE r.site_id = $1 AND r.rearrangement_id = $2 AND r.relation = 'area' AND r.before IS NOT NULL"};

}  // namespace

void QueueAreaMoves(Transaction& transaction, const SiteId& site, const rearrange::RearrangementId& id) {
  transaction.Queue(kMoveAreas, Params(site, id, NewEtag()));
}

void QueueAreaReturns(Transaction& transaction, const SiteId& site, const rearrange::RearrangementId& id) {
  transaction.Queue(kDropMovedAreas, Params(site, id));
  transaction.Queue(kRestoreAreas, Params(site, id));
}

}  // namespace enfilade::storage::postgres
