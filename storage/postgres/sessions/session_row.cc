// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/sessions/session_row.h"

#include "storage/postgres/driver/pose_columns.h"

namespace enfilade::storage::postgres {
namespace {

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
  session.create_time = row.Time();
  session.finish_time = row.OptionalTime();
  session.entry = ReadEntry(row);
  return session;
}

}  // namespace enfilade::storage::postgres
