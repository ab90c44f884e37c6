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
    "SELECT site_id FROM enfilade.sessions WHERE map_id IS NOT NULL AND state = 3 AND NOT surveyed"
    " AND (door_reports = 0 OR doors_judged) GROUP BY site_id ORDER BY min(finish_time), site_id LIMIT $1"};
constexpr Statement kMarkSurveyed{
    "marking sessions as surveyed",
    "WITH lease AS (SELECT FROM enfilade.site_leases WHERE site_id = $1 AND token = $3 FOR SHARE),"
    " marked AS (UPDATE enfilade.sessions SET surveyed = true WHERE site_id = $1 AND session_id = ANY($2)"
    "  AND EXISTS (SELECT FROM lease))"
    " SELECT EXISTS (SELECT FROM lease)"};

}  // namespace

absl::StatusOr<std::vector<SiteId>> SurveyStore::FindPending(const CallContext& context, int limit) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto found, ExecuteAlone(pool_, context, kFindSurveys, Params(std::int64_t{limit})));
  return ReadRows(found, [](Row& row) { return SiteId(std::string(row.Text())); });
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
