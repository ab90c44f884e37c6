// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "core/base/time.h"
#include "core/localization/query_scans.h"
#include "core/sensor/scan_pairing.h"

namespace enfilade::localization {

struct RecentScansOptions {
  double window = 5.0;        // m of the drive whose scans are kept
  double scan_spacing = 0.2;  // m or rad between the scans kept
  double spacing = 1.0;       // m driven or rad turned between two attempts
  double retry = 2.0;         // s, after an attempt that could not be made
};

// The scans of the last metres of a drive, to locate the robot by (Localize), and when another attempt is worthwhile:
// at the first scan, and then whenever the robot has moved on. Scans without odometry cannot be compared with each
// other: of these only the last is kept, and only the first is worth an attempt.
class RecentScans {
 public:
  explicit RecentScans(const RecentScansOptions& options = {}) : options_(options) {}

  // In the order of the log. True: locate the robot now, by scans().
  bool Add(const sensor::PairedScan& scan);
  // The last attempt could not be made: the next one is due after options.retry.
  void Retry() { retry_ = true; }

  // The last one added is always the last one here.
  const std::vector<QueryScan>& scans() const { return scans_; }
  // Where odometry had the robot at the last scan; unset: there is no odometry, or no scan.
  std::optional<Pose2> T_odom_robot() const { return scans_.empty() ? std::nullopt : scans_.back().T_odom_robot; }
  double travelled() const { return travelled_; }  // m, since the first scan
  double seconds() const;                          // since the first scan

 private:
  bool IsDue() const;
  void Keep(const sensor::PairedScan& scan);

  RecentScansOptions options_;
  std::vector<QueryScan> scans_;
  std::vector<double> travelled_at_;  // for each of scans_
  double travelled_ = 0.0;
  bool last_is_kept_ = false;  // the last scan is far enough from the one before it to stay
  TimeNs first_ = 0;
  TimeNs tried_ = 0;
  std::optional<Pose2> T_odom_tried_;  // unset: without odometry
  double travelled_tried_ = 0.0;
  bool tried_once_ = false;
  bool retry_ = false;
};

}  // namespace enfilade::localization
