// SPDX-License-Identifier: Apache-2.0
#include "core/localization/recent_scans.h"

#include <algorithm>
#include <cmath>

namespace enfilade::localization {

bool RecentScans::Add(const sensor::PairedScan& scan) {
  if (scans_.empty()) {
    first_ = scan.scan.time;
  } else if (scan.T_odom_robot.has_value() != T_odom_robot().has_value()) {
    if (!scan.T_odom_robot) return false;  // the others say more
    scans_.clear();
    travelled_at_.clear();
  }
  Keep(scan);
  if (!IsDue()) return false;
  tried_ = scan.scan.time;
  T_odom_tried_ = scan.T_odom_robot;
  travelled_tried_ = travelled_;
  tried_once_ = true;
  retry_ = false;
  return true;
}

double RecentScans::seconds() const { return scans_.empty() ? 0.0 : ToSeconds(scans_.back().scan.time - first_); }

void RecentScans::Keep(const sensor::PairedScan& scan) {
  if (!scan.T_odom_robot) {
    scans_.clear();
    travelled_at_.clear();
  }
  if (!scans_.empty()) {
    travelled_ += Between(*T_odom_robot(), *scan.T_odom_robot).translation().norm();
    if (!last_is_kept_) {
      scans_.pop_back();
      travelled_at_.pop_back();
    }
  }
  last_is_kept_ = true;
  if (!scans_.empty()) {
    const Pose2 motion = Between(*T_odom_robot(), *scan.T_odom_robot);
    last_is_kept_ =
        motion.translation().norm() >= options_.scan_spacing || std::abs(motion.yaw) >= options_.scan_spacing;
  }
  scans_.push_back({scan.scan, scan.T_odom_robot});
  travelled_at_.push_back(travelled_);
  const auto recent = std::find_if(travelled_at_.begin(), travelled_at_.end(),
                                   [&](double at) { return at >= travelled_ - options_.window; });
  scans_.erase(scans_.begin(), scans_.begin() + (recent - travelled_at_.begin()));
  travelled_at_.erase(travelled_at_.begin(), recent);
}

bool RecentScans::IsDue() const {
  if (!tried_once_) return true;
  if (!T_odom_robot()) return false;
  if (!T_odom_tried_) return true;
  if (retry_) return std::abs(ToSeconds(scans_.back().scan.time - tried_)) >= options_.retry;
  return travelled_ - travelled_tried_ >= options_.spacing ||
         std::abs(Between(*T_odom_tried_, *T_odom_robot()).yaw) >= options_.spacing;
}

}  // namespace enfilade::localization
