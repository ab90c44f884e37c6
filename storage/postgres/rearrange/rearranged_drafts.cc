// SPDX-License-Identifier: Apache-2.0
#include <vector>

#include "storage/postgres/driver/etag.h"
#include "storage/postgres/rearrange/rearrangement_changes.h"

namespace enfilade::storage::postgres {
namespace {

// What somebody appends meanwhile is moved, too. Their map is locked before them, as by whoever publishes.
constexpr Statement kLockDrafts{
    "locking drafts of maps that are merged",
    "SELECT draft_id FROM enfilade.map_drafts WHERE site_id = $1 AND map_id = $2 AND publish_time IS NULL"
    " ORDER BY draft_id FOR UPDATE"};
// `$6`, `$7`: its publications that the other map has adopted, by their numbers there and here. An id that is taken in
// the other map gets the hash of its old name.
constexpr Statement kMoveDrafts{
    "moving drafts",
    "WITH redirect AS (SELECT $2::text AS source, $3::text AS target, $4::float8[] AS pose),"
    " moved AS (SELECT d.*, CASE WHEN EXISTS (SELECT FROM enfilade.map_drafts t WHERE t.site_id = $1"
    "       AND t.map_id = r.target AND t.draft_id = d.draft_id)"
    "     THEN left(d.draft_id, 46) || '-' || left(md5(d.map_id || '/' || d.draft_id), 16)"
    "     ELSE d.draft_id END AS new_id, r.target, r.pose[1] AS x, r.pose[2] AS y, r.pose[3] AS yaw"
    "   FROM redirect r JOIN enfilade.map_drafts d ON d.site_id = $1 AND d.map_id = r.source"
    "     AND d.publish_time IS NULL),"
    " adopted AS (SELECT * FROM unnest($6::bigint[], $7::bigint[]) u (there, here)),"
    " come AS (INSERT INTO enfilade.map_drafts (site_id, map_id, draft_id, display_name, author, base_edit_version,"
    "     resolution, origin_x, origin_y, origin_yaw, head, next_sequence, active_edits, create_time, etag)"
    "   SELECT $1, m.target, m.new_id, m.display_name, m.author,"
    "     coalesce((SELECT max(a.here) FROM adopted a WHERE a.there <= m.base_edit_version),"
    "       (SELECT min(a.here) - 1 FROM adopted a),"
    "       (SELECT o.edit_version FROM enfilade.map_overlays o WHERE o.site_id = $1 AND o.map_id = m.target), 0),"
    "     m.resolution, m.x + cos(m.yaw) * m.origin_x - sin(m.yaw) * m.origin_y,"
    "     m.y + sin(m.yaw) * m.origin_x + cos(m.yaw) * m.origin_y,"
    "     atan2(sin(m.yaw + m.origin_yaw), cos(m.yaw + m.origin_yaw)), m.head, m.next_sequence, m.active_edits,"
    "     m.create_time, $5 FROM moved m)"
    " INSERT INTO enfilade.map_edits (site_id, map_id, draft_id, sequence, edit_id, author, head, active, instruction,"
    "     invisible, shape, create_time)"
    "   SELECT $1, m.target, m.new_id, e.sequence, e.edit_id, e.author, e.head, e.active, e.instruction, e.invisible,"
    "     e.shape, e.create_time FROM moved m JOIN enfilade.map_edits e"
    "     ON e.site_id = $1 AND e.map_id = m.map_id AND e.draft_id = m.draft_id"};
constexpr Statement kDeleteMovedDrafts{
    "removing drafts that were moved",
    "DELETE FROM enfilade.map_drafts WHERE site_id = $1 AND map_id = $2 AND publish_time IS NULL"};

}  // namespace

void QueueDraftMoves(Transaction& transaction, const SiteId& site, const RearrangementChange& change) {
  for (const rearrange::MapRedirect& redirect : change.rearrangement.redirects) {
    std::vector<std::int64_t> there, here;
    for (const RearrangedRaster& raster : change.rasters) {
      for (const AdoptedPublication& adopted : raster.adopted) {
        if (adopted.from != redirect.from) continue;
        there.push_back(adopted.from_version);
        here.push_back(adopted.edit_version);
      }
    }
    const Pose2& pose = redirect.T_to_from;
    transaction.Queue(kLockDrafts, Params(site, redirect.from));
    transaction.Queue(kMoveDrafts, Params(site, redirect.from, redirect.to,
                                          std::vector<double>{pose.x, pose.y, pose.yaw}, NewEtag(), there, here));
    transaction.Queue(kDeleteMovedDrafts, Params(site, redirect.from));
  }
}

}  // namespace enfilade::storage::postgres
