// SPDX-License-Identifier: Apache-2.0
#include "storage/sessions/session_growth.h"

#include <algorithm>

namespace enfilade::storage {
namespace {

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

}  // namespace enfilade::storage
