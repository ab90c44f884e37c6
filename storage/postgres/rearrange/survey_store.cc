// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/rearrange/survey_store.h"

#include <string>
#include <string_view>

#include "core/base/resource_name.h"
#include "storage/postgres/driver/rows.h"

namespace enfilade::storage::postgres {
namespace {

// Reads over all sites, as session_leases.cc does. The work it finds is then done within its site.
constexpr Statement kFindSurveys{
    "looking for sites to survey",
    "SELECT p.site_id, p.scans, p.waiting, EXISTS (SELECT FROM enfilade.sessions o WHERE o.site_id = p.site_id"
    "   AND o.finish_time IS NULL AND o.delete_time IS NULL)"
    "  OR EXISTS (SELECT FROM enfilade.mapping_work w WHERE w.site_id = p.site_id)"
    " FROM (SELECT site_id, sum(laser_scans)::bigint AS scans,"
    "   coalesce(extract(epoch FROM clock_timestamp() - min(finish_time))::double precision, 0) AS waiting"
    "  FROM enfilade.sessions WHERE map_id IS NOT NULL AND state = 3 AND NOT surveyed"
    "  AND (door_reports = 0 OR doors_judged) GROUP BY site_id ORDER BY min(finish_time), site_id LIMIT $1) p"
    " ORDER BY p.waiting DESC, p.site_id"};
constexpr Statement kMarkSurveyed{
    "marking sessions as surveyed",
    "WITH lease AS (SELECT FROM enfilade.site_leases WHERE site_id = $1 AND token = $3 FOR SHARE),"
    " marked AS (UPDATE enfilade.sessions SET surveyed = true WHERE site_id = $1 AND session_id = ANY($2)"
    "  AND EXISTS (SELECT FROM lease))"
    " SELECT EXISTS (SELECT FROM lease)"};

}  // namespace

absl::StatusOr<std::vector<PendingSurvey>> SurveyStore::FindPending(const CallContext& context, int limit) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto found, ExecuteAlone(pool_, context, kFindSurveys, Params(std::int64_t{limit})));
  return ReadRows(found, [](Row& row) {
    PendingSurvey pending;
    pending.site = SiteId(std::string(row.Text()));
    pending.scans = row.Int64();
    pending.waiting_s = row.Double();
    pending.under_way = row.Bool();
    return pending;
  });
}

absl::Status SurveyStore::MarkSurveyed(const CallContext& context, const SiteLease& lease,
                                       const std::vector<SessionId>& sessions) const {
  std::vector<std::string_view> ids;
  for (const SessionId& session : sessions) ids.push_back(session.value());
  ENFILADE_ASSIGN_OR_RETURN(const auto marked,
                            ExecuteAlone(pool_, context, kMarkSurveyed, Params(lease.site, ids, lease.token)));
  ENFILADE_ASSIGN_OR_RETURN(const bool held, ReadOne(
                                                 marked, [](Row& row) { return row.Bool(); }, "the lease"));
  if (held) return absl::OkStatus();
  return Aborted("{} has lost the lease on {}", lease.owner, NameOf(lease.site));
}

}  // namespace enfilade::storage::postgres
