// SPDX-License-Identifier: Apache-2.0
#include "server/app/mapping/session_entry.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "core/base/status_macros.h"
#include "core/slam/submaps/robot_rays.h"

namespace enfilade::server {
namespace {

constexpr auto kReadingTimeout = std::chrono::seconds(60);
constexpr std::int64_t kLastRecords = 200;
// The entry is the pose at one of the last scans. Another one is as good if the robot hardly moved in between.
constexpr double kNear = 0.2;       // m
constexpr double kNearAngle = 0.2;  // rad

absl::StatusOr<std::vector<sensor::PairedScan>> ReadLastScans(const storage::RecordStore& records,
                                                              const sensor::ScanPairingOptions& options,
                                                              const storage::Session& session) {
  const std::int64_t last = session.acknowledged_sequence;
  ENFILADE_ASSIGN_OR_RETURN(
      std::vector<sensor::Record> read,
      records.ReadSelected(storage::CallContext::WithTimeout(kReadingTimeout), session.site, session.id,
                           {.kinds = {sensor::RecordKind::kLaserScan, sensor::RecordKind::kOdometry},
                            .from_time = 0,
                            .to_time = std::numeric_limits<TimeNs>::max(),
                            .first_sequence = std::max<std::int64_t>(1, last - kLastRecords),
                            .last_sequence = last}));
  sensor::ScanPairing pairing(options);
  std::vector<sensor::PairedScan> scans;
  for (sensor::Record& record : read) pairing.Add(record.sequence, std::move(record.payload), scans);
  pairing.Flush(scans);
  return scans;
}

const sensor::PairedScan* FindNearest(const std::vector<sensor::PairedScan>& scans, const Pose2& T_odom_robot) {
  const sensor::PairedScan* nearest = nullptr;
  double least = 1.0;
  for (const sensor::PairedScan& scan : scans) {
    if (!scan.T_odom_robot) continue;
    const Pose2 way = Between(T_odom_robot, *scan.T_odom_robot);
    const double distance = std::max(way.translation().norm() / kNear, std::abs(way.yaw) / kNearAngle);
    if (distance > least) continue;
    least = distance;
    nearest = &scan;
  }
  return nearest;
}

}  // namespace

absl::StatusOr<slam::ExistingMapEntry> ReadEntry(const storage::SessionStore& sessions,
                                                 const storage::RecordStore& records,
                                                 const sensor::ScanPairingOptions& pairing,
                                                 const slam::SlamOptions& slam, const storage::Session& session) {
  slam::ExistingMapEntry entry{*session.entry.T_map_robot, session.entry.T_odom_robot};
  if (!entry.T_odom_robot || !session.entry.previous) return entry;
  const absl::StatusOr<storage::Session> previous =
      sessions.Get(storage::CallContext::WithTimeout(kReadingTimeout), session.site, *session.entry.previous);
  if (absl::IsNotFound(previous.status())) return entry;
  ENFILADE_RETURN_IF_ERROR(previous.status());
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<sensor::PairedScan> scans, ReadLastScans(records, pairing, *previous));
  const sensor::PairedScan* scan = FindNearest(scans, *entry.T_odom_robot);
  if (scan == nullptr) return entry;
  grid::ScanRays rays = slam::RobotRays(scan->scan, {slam.max_range, slam.occupancy.no_return_range});
  if (rays.hits.empty()) return entry;
  entry.T_map_robot =
      Compose(entry.T_map_robot, {Between(*entry.T_odom_robot, *scan->T_odom_robot), Eigen::Matrix3d::Zero()});
  entry.T_odom_robot = scan->T_odom_robot;
  entry.seen = std::move(rays);
  return entry;
}

}  // namespace enfilade::server
