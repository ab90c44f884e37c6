// SPDX-License-Identifier: Apache-2.0
#include <set>
#include <string>
#include <vector>

#include "core/base/resource_name.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/graph/link_point_rows.h"
#include "storage/postgres/rearrange/rearrangement_changes.h"
#include "storage/postgres/rearrange/rearrangement_rows.h"

namespace enfilade::storage::postgres {
namespace {

constexpr Statement kRemoveLinkPoints{
    "removing link points",
    "DELETE FROM enfilade.link_points t USING enfilade.rearrangement_parts p WHERE p.site_id = $1"
    " AND p.rearrangement_id = $2 AND p.kind = 5 AND t.site_id = $1 AND t.link_point_id = p.subject"
    " RETURNING t.link_point_id"};
// All of them first, so that no anchor meets one of another frame. Their evidence goes, too, and comes back from the
// images.
constexpr Statement kRemoveAnchors{
    "removing anchors",
    "DELETE FROM enfilade.link_point_anchors t USING enfilade.rearrangement_parts p WHERE p.site_id = $1"
    " AND p.rearrangement_id = $2 AND p.kind = 4 AND t.site_id = $1 AND t.link_point_id = p.subject"};
constexpr Statement kPutLinkPoint{
    "storing the link point",
    "INSERT INTO enfilade.link_points (site_id, link_point_id, kind, tag, direction_map_id, difficulty, state,"
    " changed_version) VALUES ($1, $2, $3, $4, $5, $6, $7, $8)"
    " ON CONFLICT (site_id, link_point_id) DO UPDATE SET kind = excluded.kind,"
    " direction_map_id = excluded.direction_map_id, position = NULL, yaw = NULL, world_covariance = NULL,"
    " changed_version = excluded.changed_version, etag = excluded.etag, update_time = excluded.update_time"};
constexpr Statement kPutNewAnchors{
    "storing the anchors",
    "INSERT INTO enfilade.link_point_anchors (site_id, link_point_id, map_id, ordinal, x, y, yaw, covariance)"
    " SELECT $1, $2, u.map_id, u.n, u.x, u.y, u.yaw, ($7::float8[])[u.n::integer * 9 - 8 : u.n::integer * 9]"
    " FROM unnest($3::text[], $4::float8[], $5::float8[], $6::float8[]) WITH ORDINALITY AS u (map_id, x, y, yaw, n)"};
// Evidence stays with the anchor of its map; that of a map without an anchor goes where the map's sessions have gone.
// An anchor has the evidence of one kind from one map.
constexpr Statement kPutEvidenceBack{
    "storing the evidence",
    "WITH p AS (SELECT * FROM enfilade.rearrangement_parts WHERE site_id = $1 AND rearrangement_id = $2),"
    " e AS (SELECT r.* FROM p JOIN enfilade.rearrangement_images i ON i.site_id = $1 AND i.rearrangement_id = $2"
    "     AND i.relation = 'link_point' AND i.key = p.subject,"
    "   jsonb_array_elements(nullif(i.before -> 'evidence', 'null')) e,"
    "   jsonb_populate_record(NULL::enfilade.link_point_evidence, e) r WHERE p.kind = 4),"
    " ways (source, target, x, y, yaw, rank) AS ("
    "   SELECT DISTINCT map_id::text, map_id::text, 0::float8, 0::float8, 0::float8, 0::bigint FROM e"
    "   UNION ALL SELECT source::text, target::text, x, y, yaw,"
    "     row_number() OVER (PARTITION BY target ORDER BY kind DESC, ordinal) FROM p WHERE kind IN (3, 6)),"
    " choice AS (SELECT DISTINCT ON (e.link_point_id, e.kind, w.target) e.link_point_id, e.kind, w.* FROM e"
    "   JOIN ways w ON w.source = e.map_id"
    "   JOIN enfilade.link_point_anchors a ON a.site_id = $1 AND a.link_point_id = e.link_point_id"
    "     AND a.map_id = w.target ORDER BY e.link_point_id, e.kind, w.target, w.rank)"
    " INSERT INTO enfilade.link_point_evidence"
    " (site_id, link_point_id, map_id, kind, ordinal, encoding, sha256, time_ns, x, y, yaw)"
    " SELECT $1, e.link_point_id, c.target, e.kind, e.ordinal, e.encoding, e.sha256, e.time_ns,"
    "   c.x + cos(c.yaw) * e.x - sin(c.yaw) * e.y, c.y + sin(c.yaw) * e.x + cos(c.yaw) * e.y,"
    "   enfilade.wrap_angle(e.yaw + c.yaw)"
    " FROM e JOIN choice c ON c.link_point_id = e.link_point_id AND c.kind = e.kind AND c.source = e.map_id"};
// Of a door that two maps have seen: the evidence of the candidates that it replaces, of one of them for each map.
constexpr Statement kPutJoinedEvidence{
    "storing the candidates' evidence",
    "WITH p AS (SELECT * FROM enfilade.rearrangement_parts WHERE site_id = $1 AND rearrangement_id = $2),"
    " chosen AS (SELECT DISTINCT ON (a.map_id) a.link_point_id, a.map_id, i.before"
    "   FROM p JOIN enfilade.rearrangement_images i ON i.site_id = $1 AND i.rearrangement_id = $2"
    "     AND i.relation = 'link_point' AND i.key = p.subject"
    "   JOIN p AS stored ON stored.kind = 4"
    "   JOIN enfilade.link_point_anchors a ON a.site_id = $1 AND a.link_point_id = stored.subject"
    "     AND a.map_id = i.before -> 'anchors' -> 0 ->> 'map_id'"
    "   WHERE p.kind = 5 AND NOT EXISTS (SELECT FROM enfilade.link_point_evidence h WHERE h.site_id = $1"
    "     AND h.link_point_id = a.link_point_id AND h.map_id = a.map_id) ORDER BY a.map_id, p.ordinal)"
    " INSERT INTO enfilade.link_point_evidence"
    " (site_id, link_point_id, map_id, kind, ordinal, encoding, sha256, time_ns, x, y, yaw)"
    " SELECT $1, c.link_point_id, c.map_id, e.kind, e.ordinal, e.encoding, e.sha256, e.time_ns, e.x, e.y, e.yaw"
    " FROM chosen c, jsonb_array_elements(nullif(c.before -> 'evidence', 'null')) j,"
    "   jsonb_populate_record(NULL::enfilade.link_point_evidence, j) e WHERE e.map_id = c.map_id"};

void QueueNewAnchors(Transaction& transaction, const SiteId& site, const graph::LinkPoint& point) {
  const AnchorArrays arrays(point.anchors);
  transaction.Queue(kPutNewAnchors,
                    Params(site, point.id, arrays.maps, arrays.x, arrays.y, arrays.yaw, arrays.covariances));
}

absl::Status ExplainStored(const absl::Status& status, const SiteId& site, const graph::LinkPoint& point) {
  const std::string constraint = ConstraintOf(status);
  if (constraint == "link_point_anchors_site_id_map_id_fkey") {
    return NotFound("{}: one of its maps does not exist", NameOf(site, point.id));
  }
  if (constraint == "link_points_redundant") {
    return AlreadyExists("{} would be a second one: {}", NameOf(site, point.id), std::string(status.message()));
  }
  return WithContext(status, NameOf(site, point.id));
}

}  // namespace

absl::Status ChangeLinkPoints(Transaction& transaction, const SiteId& site, const RearrangementChange& change,
                              std::int64_t version) {
  const rearrange::Rearrangement& rearrangement = change.rearrangement;
  ENFILADE_ASSIGN_OR_RETURN(const Result removed, transaction.Execute(kRemoveLinkPoints, Params(site, change.id)));
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<std::string> gone,
                            ReadRows(removed, [](Row& row) { return std::string(row.Text()); }));
  const std::set<std::string> found(gone.begin(), gone.end());
  for (const LinkPointId& id : rearrangement.removed_link_points) {
    if (!found.contains(id.value())) return NotFound("{} does not exist", NameOf(site, id));
  }
  transaction.Queue(kRemoveAnchors, Params(site, change.id));
  for (const graph::LinkPoint& point : rearrangement.link_points) {
    const std::optional<std::string_view> direction = NullIfEmpty(point.direction.value());
    transaction.Queue(kPutLinkPoint,
                      Params(site, point.id, static_cast<std::int16_t>(point.kind), point.tag, direction,
                             std::int32_t{point.difficulty}, static_cast<std::int16_t>(point.state), version));
    QueueNewAnchors(transaction, site, point);
    ENFILADE_RETURN_IF_ERROR(ExplainStored(transaction.Flush().status(), site, point));
  }
  transaction.Queue(kPutEvidenceBack, Params(site, change.id));
  if (!rearrangement.plan.empty()) transaction.Queue(kPutJoinedEvidence, Params(site, change.id));
  return PlaceLinkPointsOf(transaction, site, change.id, version);
}

}  // namespace enfilade::storage::postgres
