// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/sensor/record.h"

namespace enfilade::sensor {

// A scan with the odometry pose at its time, if there is odometry close enough in time.
struct PairedScan {
  std::int64_t sequence = 0;  // of the scan's record in its session's log
  LaserScan scan;
  std::optional<Pose2> T_odom_robot;
};

struct ScanPairingOptions {
  // A scan is paired if the nearest odometry is at most this far from it in time: robots publish scans and odometry at
  // different rates and instants. Between two neighbours the pose is interpolated.
  double window_s = 0.5;
  // A scan waits for later odometry while at most this many scans are waiting.
  std::size_t max_waiting_scans = 64;
};

struct ScanPairingCounts {
  std::int64_t paired = 0;
  std::int64_t unpaired = 0;       // no odometry within the window: delivered without a pose
  std::int64_t time_reversed = 0;  // scans or odometry older than their predecessor of the same kind: dropped
};

// Pairs scans and odometry of one session by time. Add records in log order; each call appends the scans whose pose is
// settled, in the scans' order. Deterministic: the same records in the same order give the same pairs, also across
// Serialize / Restore.
class ScanPairing {
 public:
  explicit ScanPairing(const ScanPairingOptions& options) : options_(options) {}

  void Add(std::int64_t sequence, LaserScan scan, std::vector<PairedScan>& settled);
  void Add(const Odometry& odometry, std::vector<PairedScan>& settled);
  // A record of any kind; those that are neither are ignored.
  void Add(std::int64_t sequence, RecordPayload payload, std::vector<PairedScan>& settled);
  // Settles all waiting scans: no more records will follow.
  void Flush(std::vector<PairedScan>& settled);

  const ScanPairingCounts& counts() const { return counts_; }

  std::string Serialize() const;
  // DATA_LOSS on bytes that Serialize did not write.
  static absl::StatusOr<ScanPairing> Restore(const ScanPairingOptions& options, std::string_view bytes);

 private:
  struct Waiting {
    std::int64_t sequence;
    LaserScan scan;
  };

  void Settle(bool flush, std::vector<PairedScan>& settled);
  std::optional<Pose2> PoseAt(TimeNs time) const;
  bool NextOdometryMayImprove(TimeNs time) const;

  ScanPairingOptions options_;
  ScanPairingCounts counts_;
  std::deque<Waiting> waiting_;
  std::deque<Odometry> odometry_;  // the last one before the oldest waiting scan, and all later
  TimeNs latest_scan_ = -1;
};

}  // namespace enfilade::sensor
