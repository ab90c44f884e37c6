// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/sessions/session_row.h"

#include <limits>
#include <vector>

#include "storage/postgres/driver/pose_columns.h"

namespace enfilade::storage::postgres {
namespace {

// Times are the limits of bigint if no record with a time was added.
constexpr Statement kAddGrowth{
    "counting records",
    "UPDATE enfilade.sessions s SET append_time = now(), acknowledged_sequence = u.acknowledged, highest_sequence = "
    "u.highest,"
    " laser_scans = s.laser_scans + u.laser_scans, odometry = s.odometry + u.odometry, images = s.images + u.images,"
    " point_clouds = s.point_clouds + u.point_clouds, withheld = s.withheld + u.withheld,"
    " door_reports = s.door_reports + u.door_reports,"
    " payload_bytes = s.payload_bytes + u.payload_bytes,"
    " first_time_ns = nullif(least(s.first_time_ns, u.first_time), 9223372036854775807),"
    " last_time_ns = nullif(greatest(s.last_time_ns, u.last_time), -9223372036854775808)"
    " FROM unnest($2::text[], $3::bigint[], $4::bigint[], $5::bigint[], $6::bigint[], $7::bigint[], $8::bigint[],"
    " $9::bigint[], $10::bigint[], $11::bigint[], $12::bigint[], $13::bigint[]) AS u (session_id, acknowledged,"
    " highest, laser_scans, odometry, images, point_clouds, withheld, door_reports, payload_bytes, first_time,"
    " last_time)"
    " WHERE s.site_id = $1 AND s.session_id = u.session_id"};

sensor::SessionEntry ReadEntry(Row& row) {
  sensor::SessionEntry entry;
  if (const auto previous = row.OptionalText()) entry.previous = SessionId(std::string(*previous));
  entry.T_map_robot = ReadOptionalPoseWithCovariance(row);
  entry.T_odom_robot = ReadOptionalPose(row);
  return entry;
}

}  // namespace

Session ReadSession(Row& row) {
  Session session;
  session.site = SiteId(std::string(row.Text()));
  session.id = SessionId(std::string(row.Text()));
  session.robot = RobotId(std::string(row.Text()));
  if (const auto map = row.OptionalText()) session.map = MapId(std::string(*map));
  session.state = static_cast<SessionState>(row.Int16());
  session.acknowledged_sequence = row.Int64();
  session.highest_sequence = row.Int64();
  session.mapped_sequence = row.Int64();
  for (std::int64_t* count :
       {&session.record_counts.laser_scans, &session.record_counts.odometry, &session.record_counts.images,
        &session.record_counts.point_clouds, &session.record_counts.withheld, &session.record_counts.door_reports,
        &session.mapping_counts.paired, &session.mapping_counts.unpaired, &session.mapping_counts.time_reversed,
        &session.mapping_counts.used, &session.mapping_counts.keyframes, &session.mapping_counts.lost,
        &session.payload_bytes}) {
    *count = row.Int64();
  }
  session.first_time = row.OptionalInt64();
  session.last_time = row.OptionalInt64();
  session.error = row.Text();
  session.records_deleted = row.Bool();
  session.doors_judged = row.Bool();
  session.surveyed = row.Bool();
  session.create_time = row.Time();
  session.finish_time = row.OptionalTime();
  session.entry = ReadEntry(row);
  return session;
}

void QueueGrowth(Transaction& transaction, const SiteId& site,
                 absl::Span<const std::pair<std::string_view, const SessionGrowth*>> growths) {
  constexpr TimeNs kNever = std::numeric_limits<TimeNs>::max();
  constexpr TimeNs kAlways = std::numeric_limits<TimeNs>::min();
  std::vector<std::string_view> sessions;
  std::vector<std::int64_t> acknowledged, highest, scans, odometry, images, clouds, withheld, doors, bytes, first, last;
  for (const auto& [session, growth] : growths) {
    sessions.push_back(session);
    acknowledged.push_back(growth->acknowledged);
    highest.push_back(growth->highest);
    scans.push_back(growth->counts.laser_scans);
    odometry.push_back(growth->counts.odometry);
    images.push_back(growth->counts.images);
    clouds.push_back(growth->counts.point_clouds);
    withheld.push_back(growth->counts.withheld);
    doors.push_back(growth->counts.door_reports);
    bytes.push_back(growth->payload_bytes);
    first.push_back(growth->first_time.value_or(kNever));
    last.push_back(growth->last_time.value_or(kAlways));
  }
  transaction.Queue(kAddGrowth, Params(site, sessions, acknowledged, highest, scans, odometry, images, clouds, withheld,
                                       doors, bytes, first, last));
}

}  // namespace enfilade::storage::postgres
