// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "core/geometry/pose2.h"
#include "core/sensor/laser_scan.h"

namespace enfilade::robot {

struct ContinuityOptions {
  // Odometry jumps if it goes farther between two scans.
  double jump = 1.0;            // m, and in addition
  double jump_speed = 5.0;      // m/s
  double blind_distance = 5.0;  // m driven without seeing walls, after which odometry alone says too little
  int min_hits = 30;            // of a scan that sees walls
  // Two scans contradict each other by the shares of their hits that lie where the other one has seen free space,
  // wherever the robot was within these errors of the odometry: wheels slip.
  double yaw_error = 0.3;       // rad
  double position_error = 0.3;  // m
  // They do if the two shares together exceed this ...
  double contradicted = 0.6;
  // ... or this, and each of them the next. What only comes near hides what was there: that is one share of them.
  double exchanged = 0.3;
  double exchanged_each = 0.08;
  // What follows such a scan, and agrees with it, is elsewhere, too, if the two shares exceed this.
  double alike = 0.2;
  double comparable = 0.5;        // m; farther apart, scans see too different things to contradict each other
  double comparable_yaw = 0.4;    // rad
  double comparable_after = 3.0;  // times as far, of what follows
  double tolerance = 0.3;         // m, of a hit
  double range_tolerance = 0.05;  // and in addition per metre of range: for errors of the yaw
  double odometry_works = 0.2;    // m; odometry that has not even moved so far says nothing about the scans
  int scans = 4;                  // in a row that contradict what was before, or that agree with each other
};

// Watches whether a robot's scans and odometry continue what was before. They do not if the robot is carried away, its
// odometry jumps, or it drives blind. What follows must not be mapped as if it did. Pure.
class Continuity {
 public:
  explicit Continuity(const ContinuityOptions& options = {}) : options_(options) {}

  // In order of time. Why this scan does not continue those before; unset: it does. After a break, the next one is
  // found only once the robot is settled.
  std::optional<std::string> Add(const sensor::LaserScan& scan, const Pose2& T_odom_robot);
  // The last scan contradicts those before, or the last few do: whether the robot was carried is not known yet.
  bool suspicious() const { return suspect_ > 0; }
  // The last scans see walls and agree with each other.
  bool settled() const { return agreeing_ >= options_.scans; }

 private:
  struct View {
    std::vector<Eigen::Vector2d> hits;  // in the robot's frame
    std::vector<float> reach;           // m, free at least so far, by direction; negative: not seen
    Pose2 T_odom_robot;
  };
  View ViewOf(const sensor::LaserScan& scan, const Pose2& T_odom_robot) const;
  // The shares of the hits of two views that lie where the other one has seen free space.
  struct Contradiction {
    double of_a = 1.0;
    double of_b = 1.0;
    double sum() const { return of_a + of_b; }
  };
  // Of the hits of `a` in directions that `b` has seen, the share that lies in its free space.
  double FreeShare(const View& a, const View& b, const Pose2& T_b_a) const;
  // The least within the errors of the odometry, or little.
  Contradiction Compare(const View& a, const View& b) const;
  bool IsLarge(const Contradiction& found) const;
  // Whether the robot may have been carried between known_ and `view`.
  bool IsSuspect(const View& view) const;
  std::optional<std::string> Break(std::string reason);

  ContinuityOptions options_;
  std::optional<View> known_;  // the last view that continues those before; unset after a break
  std::optional<View> last_;
  int suspect_ = 0;     // views in a row that contradict known_
  int agreeing_ = 0;    // views in a row that agree with the one before
  double blind_ = 0.0;  // m
  double moved_ = 0.0;  // m, in all
  std::optional<Pose2> T_odom_last_;
  TimeNs last_time_ = 0;
};

}  // namespace enfilade::robot
