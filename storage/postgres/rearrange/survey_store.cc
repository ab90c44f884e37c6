// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/rearrange/survey_store.h"

#include <string>
#include <string_view>

#include "core/base/resource_name.h"
#include "storage/postgres/driver/rows.h"

namespace enfilade::storage::postgres {
namespace {

// A robot begins its next session within this time, s.
constexpr double kBetweenSessions = 1.0;
// Records of a robot that is followed live are mapped within this time, s, and the door before them is judged.
constexpr double kUsualLag = 2.0;

// Reads over all sites, as session_leases.cc does. The work it finds is then done within its site.
constexpr Statement kFindSurveys{
    "looking for sites to survey",
    "SELECT site_id, sessions, drive_ended,"
    " EXISTS (SELECT FROM enfilade.mapping_work w WHERE w.site_id = p.site_id"
    "  AND w.waiting_since < now() - $2 * interval '1 s')"
    " OR EXISTS (SELECT FROM enfilade.sessions n JOIN enfilade.sessions b"
    "  ON b.site_id = n.site_id AND b.session_id = n.previous_session_id"
    "  WHERE n.site_id = p.site_id AND n.map_id IS NULL AND n.previous_session_id IS NOT NULL AND n.delete_time IS NULL"
    "  AND n.state IN (1, 2) AND b.finish_time < now() - $2 * interval '1 s')"
    " FROM (SELECT site_id, min(finish_time) AS since, count(*) AS sessions, bool_or("
    "  NOT EXISTS (SELECT FROM enfilade.sessions u WHERE u.site_id = s.site_id AND u.map_id IS NOT NULL"
    "   AND u.state IN (1, 2) AND u.robot_id IS NOT DISTINCT FROM s.robot_id AND u.delete_time IS NULL)"
    "  AND NOT EXISTS (SELECT FROM enfilade.sessions u WHERE u.site_id = s.site_id AND u.map_id IS NULL"
    "   AND u.previous_session_id IS NOT NULL AND u.state IN (1, 2) AND u.robot_id IS NOT DISTINCT FROM s.robot_id"
    "   AND u.delete_time IS NULL)"
    "  AND NOT EXISTS (SELECT FROM enfilade.sessions u WHERE u.site_id = s.site_id"
    "   AND u.finish_time > now() - $1 * interval '1 s' AND u.robot_id IS NOT DISTINCT FROM s.robot_id"
    "   AND u.delete_time IS NULL)) AS drive_ended"
    " FROM enfilade.sessions s WHERE map_id IS NOT NULL AND state = 3 AND NOT surveyed"
    " AND (door_reports = 0 OR doors_judged) GROUP BY site_id) p ORDER BY since, site_id"};
constexpr Statement kMarkSurveyed{
    "marking sessions as surveyed",
    "WITH lease AS (SELECT FROM enfilade.site_leases WHERE site_id = $1 AND token = $3 FOR SHARE),"
    " marked AS (UPDATE enfilade.sessions SET surveyed = true WHERE site_id = $1 AND session_id = ANY($2)"
    "  AND EXISTS (SELECT FROM lease))"
    " SELECT EXISTS (SELECT FROM lease)"};

}  // namespace

absl::StatusOr<std::vector<PendingSurvey>> SurveyStore::FindPending(const CallContext& context) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto found,
                            ExecuteAlone(pool_, context, kFindSurveys, Params(kBetweenSessions, kUsualLag)));
  return ReadRows(found, [](Row& row) {
    PendingSurvey pending{.site = SiteId(std::string(row.Text()))};
    pending.sessions = row.Int64();
    pending.drive_ended = row.Bool();
    pending.mapping_lags = row.Bool();
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
