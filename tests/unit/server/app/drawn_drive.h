// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "core/sensor/record.h"
#include "tests/unit/core/localization/drawn_map.h"

namespace enfilade::server {

// The log of a drive through drawn rooms: straight from one pose to the next in steps of 0.1 m (and 0.1 rad), a scan
// and odometry at each. Odometry starts at `T_odom_start`.
inline std::vector<sensor::Record> RecordDrive(const localization::DrawnMap& map, const std::vector<Pose2>& way,
                                               const Pose2& T_odom_start = {3.0, -2.0, 0.7}, bool odometry = true) {
  std::vector<sensor::Record> log;
  const auto add = [&](sensor::RecordPayload payload) {
    log.push_back({static_cast<std::int64_t>(log.size()) + 1, std::move(payload)});
  };
  TimeNs time = kNsPerSecond;
  const auto see = [&](const Pose2& pose) {
    time += kNsPerSecond / 5;
    if (odometry) add(sensor::Odometry{time, T_odom_start * Between(way.front(), pose)});
    sensor::LaserScan scan = map.Scan(pose);
    scan.time = time;
    add(std::move(scan));
  };
  see(way.front());
  for (std::size_t i = 1; i < way.size(); ++i) {
    const Pose2 motion = Between(way[i - 1], way[i]);
    const double steps = std::ceil(std::max(motion.translation().norm(), std::abs(motion.yaw)) / 0.1);
    for (double step = 1.0; step <= steps; step += 1.0) see(Interpolate(way[i - 1], way[i], step / steps));
  }
  return log;
}

}  // namespace enfilade::server
