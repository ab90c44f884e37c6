// SPDX-License-Identifier: Apache-2.0
#include "storage/graph/plan_join_store.h"

#include <algorithm>
#include <string_view>

#include "storage/postgres/driver/rows.h"

namespace enfilade::storage {
namespace {

using postgres::ExecuteAlone;
using postgres::Params;
using postgres::ReadRows;
using postgres::Row;
using postgres::Statement;

// Reads over all sites, as session_leases.cc does. The work it finds is then done within its site.
constexpr Statement kListSites{
    "looking for sites with plans",
    "SELECT g.site_id, g.graph_version FROM enfilade.site_graphs g WHERE EXISTS ("
    "  SELECT FROM enfilade.prior_maps p WHERE p.site_id = g.site_id AND p.state = 3)"
    " OR EXISTS (SELECT FROM enfilade.rearrangements r WHERE r.site_id = g.site_id AND r.prior_map_id IS NOT NULL"
    "   AND r.version_undone = 0 AND EXISTS (SELECT FROM enfilade.rearrangement_parts p"
    "     JOIN enfilade.link_points l ON l.site_id = p.site_id AND l.link_point_id = p.subject"
    "     WHERE p.site_id = r.site_id AND p.rearrangement_id = r.rearrangement_id AND p.kind = 4))"
    " ORDER BY g.site_id"};
// A passage from one of the two maps into the other one, by a link point that a survey has replaced since.
#define ENFILADE_REPLACED_PASSAGE                                                                               \
  "(NOT EXISTS (SELECT FROM enfilade.link_points o WHERE o.site_id = $1 AND o.link_point_id = v.link_point_id)" \
  " AND EXISTS (SELECT FROM enfilade.sessions s JOIN enfilade.link_point_anchors a ON a.site_id = s.site_id"    \
  "     AND a.map_id = s.map_id JOIN enfilade.link_point_anchors b ON b.site_id = a.site_id"                    \
  "     AND b.link_point_id = a.link_point_id AND b.map_id <> a.map_id WHERE s.site_id = $1"                    \
  "   AND s.session_id = v.session_id AND a.link_point_id = p.subject AND b.map_id = v.map_id))"
constexpr Statement kListJoins{
    "listing what plans have joined",
    "SELECT r.rearrangement_id, r.prior_map_id, p.subject, r.reason, r.version_undone > 0,"
    " EXISTS (SELECT FROM enfilade.door_verdicts v WHERE v.site_id = $1 AND v.map_id IS NOT NULL"
    "   AND v.create_time >= r.create_time AND (v.link_point_id = p.subject OR " ENFILADE_REPLACED_PASSAGE
    ")),"
    " coalesce((SELECT string_agg(c.subject, ' ' ORDER BY c.ordinal) FROM enfilade.rearrangement_parts c"
    "   WHERE c.site_id = $1 AND c.rearrangement_id = r.rearrangement_id AND c.kind = 5), '')"
    " FROM enfilade.rearrangements r JOIN enfilade.rearrangement_parts p ON p.site_id = r.site_id"
    "   AND p.rearrangement_id = r.rearrangement_id AND p.kind = 4"
    " WHERE r.site_id = $1 AND r.prior_map_id IS NOT NULL AND NOT r.plan_withdrawn"
    " AND (r.version_undone > 0 OR EXISTS (SELECT FROM enfilade.link_points l WHERE l.site_id = $1"
    "   AND l.link_point_id = p.subject)) ORDER BY r.version_after DESC"};
constexpr Statement kMarkWithdrawn{
    "marking what a plan has joined as withdrawn",
    "UPDATE enfilade.rearrangements SET plan_withdrawn = true WHERE site_id = $1 AND rearrangement_id = $2"};

std::vector<LinkPointId> SplitIds(std::string_view text) {
  std::vector<LinkPointId> ids;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(' '), text.size());
    ids.emplace_back(std::string(text.substr(0, end)));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return ids;
}

}  // namespace

absl::StatusOr<std::vector<SiteWithPlans>> PlanJoinStore::ListSites(const CallContext& context) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto found, ExecuteAlone(pool_, context, kListSites, Params()));
  return ReadRows(found, [](Row& row) {
    SiteWithPlans site;
    site.site = SiteId(std::string(row.Text()));
    site.graph_version = row.Int64();
    return site;
  });
}

absl::StatusOr<std::vector<PlanJoin>> PlanJoinStore::List(const CallContext& context, const SiteId& site) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto found, ExecuteAlone(pool_, context, kListJoins, Params(site)));
  return ReadRows(found, [](Row& row) {
    PlanJoin join;
    join.rearrangement = rearrange::RearrangementId(std::string(row.Text()));
    join.plan = PriorMapId(std::string(row.Text()));
    join.link_point = LinkPointId(std::string(row.Text()));
    join.reason = row.Text();
    join.undone = row.Bool();
    join.passed = row.Bool();
    join.candidates = SplitIds(row.Text());
    return join;
  });
}

absl::Status PlanJoinStore::MarkWithdrawn(const CallContext& context, const SiteId& site,
                                          const rearrange::RearrangementId& id) const {
  return ExecuteAlone(pool_, context, kMarkWithdrawn, Params(site, id)).status();
}

}  // namespace enfilade::storage
