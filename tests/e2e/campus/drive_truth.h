// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "client/simulator/campus/campus.h"
#include "core/base/time.h"
#include "core/geometry/pose2.h"

namespace enfilade::testing {

struct TruePoint {
  TimeNs time = 0;
  Pose2 T_campus_robot;
  std::string level;
  std::string area;  // empty: in none
};

struct PassedDoor {
  TimeNs time = 0;
  Pose2 T_campus_robot;
  std::string level;
  std::string door;
  std::string from;  // areas
  std::string to;
};

// Where one robot really was.
struct DriveTruth {
  std::string robot;
  std::vector<TruePoint> poses;      // by time, at every scan; not empty
  std::vector<PassedDoor> passages;  // by time
};

// Of a file that `enfilade robot --truth` wrote. Throws if it has no poses.
DriveTruth ReadTruth(const std::string& robot, const std::filesystem::path& file);

// Between the poses around `time`; before the first and after the last, that pose.
Pose2 TruthAt(const DriveTruth& truth, TimeNs time);

struct TrueDoor {
  std::string id;
  Eigen::Vector2d a = Eigen::Vector2d::Zero();  // the jambs, in the campus frame
  Eigen::Vector2d b = Eigen::Vector2d::Zero();
};

// Those that are doors, not mere openings.
std::vector<TrueDoor> DoorsOf(const simulator::Campus& campus);

}  // namespace enfilade::testing
