// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/sessions/session_growth.h"

#include <algorithm>
#include <vector>

namespace enfilade::storage::postgres {
namespace {

// Times are the numbers' limits where no record with a time was added.
constexpr Statement kGrow{
    "counting records",
    "UPDATE enfilade.sessions s SET acknowledged_sequence = u.acknowledged, highest_sequence = u.highest,"
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

std::int64_t& CountOf(RecordCounts& counts, sensor::RecordKind kind) {
  switch (kind) {
    case sensor::RecordKind::kLaserScan:
      return counts.laser_scans;
    case sensor::RecordKind::kOdometry:
      return counts.odometry;
    case sensor::RecordKind::kImage:
      return counts.images;
    case sensor::RecordKind::kPointCloud:
      return counts.point_clouds;
    case sensor::RecordKind::kDoorReport:
      return counts.door_reports;
    default:
      return counts.withheld;
  }
}

}  // namespace

void SessionGrowth::Add(const sensor::Record& record, std::int64_t record_bytes) {
  if (record.sequence == acknowledged + 1) {
    if (highest <= acknowledged) {
      acknowledged = record.sequence;
    } else {
      filled_hole = true;
    }
  }
  highest = std::max(highest, record.sequence);
  const sensor::RecordKind kind = sensor::KindOf(record);
  ++CountOf(counts, kind);
  payload_bytes += record_bytes;
  if (kind == sensor::RecordKind::kWithheld) return;
  const TimeNs time = sensor::TimeOf(record);
  first_time = std::min(first_time.value_or(time), time);
  last_time = std::max(last_time.value_or(time), time);
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
  transaction.Queue(kGrow, Params(site, sessions, acknowledged, highest, scans, odometry, images, clouds, withheld,
                                  doors, bytes, first, last));
}

}  // namespace enfilade::storage::postgres
