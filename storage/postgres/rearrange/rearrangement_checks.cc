// SPDX-License-Identifier: Apache-2.0
#include <map>
#include <string>
#include <utility>

#include "storage/graph/rearrangement_rules.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/rearrange/rearrangement_changes.h"

namespace enfilade::storage::postgres {
namespace {

// FOR UPDATE: new sessions, which refer to the map, wait and then follow its redirect.
constexpr Statement kLockMapsOf{
    "locking the maps",
    "SELECT map_id, redirect_map_id IS NOT NULL FROM enfilade.maps WHERE site_id = $1 AND map_id IN ("
    "  SELECT unnest(ARRAY[source, CASE WHEN kind <> 2 THEN target END]) FROM enfilade.rearrangement_parts"
    "  WHERE site_id = $1 AND rearrangement_id = $2 AND kind IN (2, 3, 6)) ORDER BY map_id FOR UPDATE"};
constexpr Statement kLockSessionsOf{
    "locking the sessions",
    "SELECT session_id, coalesce(map_id::text, ''), state, records_deleted FROM enfilade.sessions"
    " WHERE site_id = $1 AND session_id IN (SELECT subject FROM enfilade.rearrangement_parts"
    "  WHERE site_id = $1 AND rearrangement_id = $2 AND kind IN (2, 3))"
    " AND delete_time IS NULL ORDER BY session_id FOR UPDATE"};
constexpr Statement kFindEmptyCut{
    "looking for cuts that cut nothing off",
    "SELECT c.subject, c.first_sequence FROM enfilade.rearrangement_parts c, LATERAL (SELECT max(p.first_sequence) AS "
    "first_sequence"
    "   FROM enfilade.rearrangement_parts p WHERE p.site_id = $1 AND p.rearrangement_id = $2 AND p.kind = 2"
    "   AND p.subject = c.subject AND p.target <> c.target AND p.first_sequence <= c.first_sequence) before"
    " WHERE c.site_id = $1 AND c.rearrangement_id = $2 AND c.kind = 2"
    " AND (SELECT NOT (coalesce(bool_or(n.sequence < c.first_sequence AND n.sequence >= coalesce("
    "     before.first_sequence, 0)), false) AND coalesce(bool_or(n.sequence >= c.first_sequence), false))"
    "   FROM enfilade.slam_nodes n WHERE n.site_id = $1 AND n.session_id = c.subject) LIMIT 1"};
constexpr Statement kFindLeftSession{
    "looking for sessions that are left",
    "SELECT s.session_id, p.subject FROM enfilade.rearrangement_parts p"
    " JOIN enfilade.sessions s ON s.site_id = p.site_id AND s.map_id = p.subject AND s.delete_time IS NULL"
    " WHERE p.site_id = $1 AND p.rearrangement_id = $2 AND p.kind = 6 AND NOT EXISTS ("
    "  SELECT FROM enfilade.rearrangement_parts m WHERE m.site_id = $1 AND m.rearrangement_id = $2 AND m.kind = 3"
    "  AND m.subject = s.session_id) ORDER BY s.session_id LIMIT 1"};
constexpr Statement kFindLeftAnchor{
    "looking for link points that are left",
    "SELECT a.link_point_id, p.subject FROM enfilade.rearrangement_parts p"
    " JOIN enfilade.link_point_anchors a ON a.site_id = p.site_id AND a.map_id = p.subject"
    " WHERE p.site_id = $1 AND p.rearrangement_id = $2 AND p.kind = 6 AND NOT EXISTS ("
    "  SELECT FROM enfilade.rearrangement_parts m WHERE m.site_id = $1 AND m.rearrangement_id = $2"
    "  AND m.kind IN (4, 5) AND m.subject = a.link_point_id) ORDER BY a.link_point_id LIMIT 1"};
constexpr Statement kFindRedirectedRoot{
    "looking for the root map",
    "SELECT root_map_id FROM enfilade.site_graphs g JOIN enfilade.rearrangement_parts p ON p.site_id = g.site_id"
    " AND p.subject = g.root_map_id WHERE g.site_id = $1 AND p.rearrangement_id = $2 AND p.kind = 6"};
constexpr Statement kKeepImages{
    "keeping what was before",
    "WITH p AS (SELECT * FROM enfilade.rearrangement_parts WHERE site_id = $1 AND rearrangement_id = $2),"
    " m AS (SELECT DISTINCT unnest(ARRAY[source, CASE WHEN kind <> 2 THEN target END])::text AS map FROM p"
    "   WHERE kind IN (2, 3, 6)),"
    " k (relation, key) AS ("
    "  SELECT r, map FROM m, unnest(ARRAY['map', 'layers', 'place']) r WHERE map IS NOT NULL"
    "  UNION SELECT r, subject FROM p, unnest(ARRAY['session', 'slam']) r WHERE kind = 3"
    "  UNION SELECT r, s FROM p, unnest(ARRAY['session', 'slam', 'closures']) r,"
    "    unnest(ARRAY[subject, target]) s WHERE kind = 2"
    "  UNION SELECT 'verdict', v.session_id || '/' || v.sequence FROM p JOIN enfilade.door_verdicts v"
    "    ON v.site_id = $1 AND v.session_id = p.subject AND v.sequence >= p.first_sequence WHERE kind = 2"
    "  UNION SELECT 'verdict', v.session_id || '/' || v.sequence FROM p"
    "    JOIN enfilade.sessions s ON s.site_id = $1 AND s.session_id = p.subject"
    "    JOIN enfilade.door_verdicts v ON v.site_id = $1 AND v.session_id = s.previous_session_id"
    "      AND v.map_id = p.source WHERE kind = 3"
    "  UNION SELECT 'verdict', v.session_id || '/' || v.sequence FROM p"
    "    JOIN enfilade.door_verdicts v ON v.site_id = $1 AND v.map_id = p.subject WHERE kind = 6"
    "  UNION SELECT 'link_point', subject FROM p WHERE kind IN (4, 5)"
    "  UNION SELECT 'control_points', '' FROM p JOIN enfilade.control_points c"
    "    ON c.site_id = $1 AND c.map_id = p.subject WHERE kind = 6"
    "  UNION SELECT 'robot_pose', r.robot_id FROM p JOIN enfilade.robot_poses r ON r.site_id = $1"
    "    AND r.map_id = p.source AND (kind = 6 OR r.session_id = p.subject) WHERE kind IN (2, 3, 6))"
    " INSERT INTO enfilade.rearrangement_images (site_id, rearrangement_id, relation, key, before)"
    " SELECT $1, $2, relation, key, enfilade.rearrangement_image($1, relation, key) FROM k"};
constexpr Statement kKeepBlobs{
    "keeping the blobs of what was before",
    "INSERT INTO enfilade.rearrangement_blobs (site_id, rearrangement_id, sha256)"
    " SELECT $1, $2, e.sha256 FROM enfilade.rearrangement_parts p JOIN enfilade.link_point_evidence e"
    "   ON e.site_id = p.site_id AND e.link_point_id = p.subject"
    "   WHERE p.site_id = $1 AND p.rearrangement_id = $2 AND p.kind IN (4, 5)"
    " UNION SELECT $1, $2, t.sha256 FROM enfilade.rearrangement_parts p JOIN enfilade.map_layers l"
    "   ON l.site_id = p.site_id AND l.map_id = p.source AND l.session_id = p.subject"
    "   JOIN enfilade.map_layer_tiles t"
    "     ON t.site_id = l.site_id AND t.map_id = l.map_id AND t.position = l.position"
    "   WHERE p.site_id = $1 AND p.rearrangement_id = $2 AND p.kind IN (2, 3)"};
constexpr Statement kKeepImagesAfter{"keeping what is now",
                                     "UPDATE enfilade.rearrangement_images"
                                     " SET after = enfilade.rearrangement_image(site_id, relation, key)"
                                     " WHERE site_id = $1 AND rearrangement_id = $2"};

absl::StatusOr<std::map<MapId, bool>> ReadLockedMaps(const Result& locked) {
  std::map<MapId, bool> redirected;
  for (int i = 0; i < locked.rows(); ++i) {
    Row row(locked, i);
    MapId map{std::string(row.Text())};
    redirected[std::move(map)] = row.Bool();
    ENFILADE_RETURN_IF_ERROR(row.status());
  }
  return redirected;
}

absl::StatusOr<std::map<SessionId, SessionToRearrange>> ReadLockedSessions(const Result& locked) {
  std::map<SessionId, SessionToRearrange> sessions;
  for (int i = 0; i < locked.rows(); ++i) {
    Row row(locked, i);
    SessionToRearrange& stored = sessions[SessionId(std::string(row.Text()))];
    stored.map = MapId(std::string(row.Text()));
    stored.state = static_cast<SessionState>(row.Int16());
    stored.records_deleted = row.Bool();
    ENFILADE_RETURN_IF_ERROR(row.status());
  }
  return sessions;
}

}  // namespace

void QueueRearranging(Transaction& transaction, const rearrange::RearrangementId& id) {
  transaction.QueueSetting("enfilade.rearranging", id.value());
}

absl::Status LockAndCheck(Transaction& transaction, const SiteId& site, const RearrangementChange& change) {
  const rearrange::Rearrangement& rearrangement = change.rearrangement;
  const Params key(site, change.id);
  ENFILADE_ASSIGN_OR_RETURN(const Result locked, transaction.Execute(kLockMapsOf, key));
  ENFILADE_ASSIGN_OR_RETURN(auto maps, ReadLockedMaps(locked));
  ENFILADE_RETURN_IF_ERROR(CheckRearrangedMaps(site, rearrangement, std::move(maps)));
  transaction.Queue(kLockSessionsOf, key);
  transaction.Queue(kFindEmptyCut, key);
  transaction.Queue(kFindLeftSession, key);
  transaction.Queue(kFindLeftAnchor, key);
  transaction.Queue(kFindRedirectedRoot, key);
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.Flush());
  ENFILADE_ASSIGN_OR_RETURN(const auto sessions, ReadLockedSessions(results[results.size() - 5]));
  ENFILADE_RETURN_IF_ERROR(CheckRearrangedSessions(site, rearrangement, sessions));
  if (const Result& empty = results[results.size() - 4]; empty.rows() > 0) {
    Row row(empty, 0);
    const SessionId session{std::string(row.Text())};
    return NothingToCutOff(site, session, row.Int64());
  }
  if (const Result& left = results[results.size() - 3]; left.rows() > 0) {
    Row row(left, 0);
    const SessionId session{std::string(row.Text())};
    return SessionIsLeft(site, session, MapId(std::string(row.Text())));
  }
  if (const Result& left = results[results.size() - 2]; left.rows() > 0) {
    Row row(left, 0);
    const LinkPointId point{std::string(row.Text())};
    return AnchorIsLeft(site, point, MapId(std::string(row.Text())));
  }
  if (const Result& root = results[results.size() - 1]; root.rows() > 0) {
    Row row(root, 0);
    return RootWouldDisappear(MapId(std::string(row.Text())));
  }
  return absl::OkStatus();
}

void QueueImagesBefore(Transaction& transaction, const SiteId& site, const rearrange::RearrangementId& id) {
  transaction.Queue(kKeepImages, Params(site, id));
  transaction.Queue(kKeepBlobs, Params(site, id));
}

void QueueImagesAfter(Transaction& transaction, const SiteId& site, const rearrange::RearrangementId& id) {
  transaction.Queue(kKeepImagesAfter, Params(site, id));
}

}  // namespace enfilade::storage::postgres
