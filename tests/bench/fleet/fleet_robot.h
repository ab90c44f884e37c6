// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/sdk/connection.h"
#include "tests/bench/fleet/recorded_drive.h"

namespace enfilade::bench {

// How long after it was due a batch was acknowledged. A robot that falls behind is late with all that follows, and so
// is what this says: waiting is not left out.
struct Acknowledged {
  double at = 0.0;  // s since the fleet's start
  double latency_ms = 0.0;
};

struct FleetClock {
  std::chrono::steady_clock::time_point start;
  std::chrono::steady_clock::time_point end;
};

struct FleetRobotOptions {
  SiteId site;
  RobotId robot;
  bool first_of_site = false;  // its drive makes the first map; the others' enter it
  double start_s = 0.0;        // after the fleet's start
  double pose_reports_hz = 1.0;
};

struct FleetRobotResult {
  std::vector<Acknowledged> acknowledged;
  std::int64_t records = 0;
  std::int64_t scans = 0;
  std::int64_t pose_reports = 0;
  int sessions = 0;
  absl::Status status;  // of the first call that failed, which ended the robot
};

// One robot that drives again and again until the clock ends, in real time, over its own connection; blocks meanwhile.
FleetRobotResult DriveUntilEnd(const client::Connection& connection, const RecordedDrive& drive,
                               const FleetRobotOptions& options, const FleetClock& clock);

}  // namespace enfilade::bench
