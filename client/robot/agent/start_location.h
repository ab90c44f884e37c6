// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/sdk/connection.h"
#include "core/base/ids.h"
#include "core/localization/recent_scans.h"
#include "core/sensor/scan_pairing.h"

namespace enfilade::robot {

// What the server says about where a robot is.
struct StartAnswer {
  std::string map;                 // its id; empty: nowhere known
  PoseWithCovariance T_map_robot;  // the likeliest, at the last scan
  bool confident = false;
  int hypotheses = 0;  // poses that the robot may have
  int maps_searched = 0;
  std::string reason;  // for people
};

// Asks the server where the scans were taken.
using LocateByScans = std::function<absl::StatusOr<StartAnswer>(const std::vector<sensor::PairedScan>&)>;
// By LocalizeRobot.
LocateByScans LocateOnServer(const client::Connection& connection, const SiteId& site);

// The map that the robot's first session goes into.
struct StartDecision {
  std::string map;                 // the id of an existing one; empty: a new one
  PoseWithCovariance T_map_robot;  // in an existing map, when odometry reads T_odom_robot
  Pose2 T_odom_robot;
  std::string reason;  // for people
};

struct StartLocationOptions {
  // How far the robot drives, and how long it records, before it begins a new map.
  double distance = 10.0;  // m
  double time = 60.0;      // s
};

// Decides into which map the first session of a robot goes that does not know where it is. Scans go in; when Add says
// so, the server is asked, and its answer goes in, too. Poses that are not certain are only hypotheses: the robot
// drives on, and the server is asked again with more scans. Pure.
class StartLocation {
 public:
  explicit StartLocation(const StartLocationOptions& options = {}) : options_(options) {}

  // A scan with odometry. True: ask the server about scans() now.
  bool Add(const sensor::PairedScan& scan);
  std::vector<sensor::PairedScan> scans() const;
  // `T_odom_robot`: of the last scan that was asked about.
  void Answer(const absl::StatusOr<StartAnswer>& answer, const Pose2& T_odom_robot);

  // Unset: not decided yet.
  std::optional<StartDecision> Decide() const;
  // The session ends here, or the robot has gone through a door: if nothing is certain by now, the map is a new one.
  StartDecision DecideNow() const;

 private:
  StartLocationOptions options_;
  localization::RecentScans recent_;
  std::optional<StartDecision> decision_;
  std::string reason_ = "the server was not asked";
};

}  // namespace enfilade::robot
