// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tests/e2e/campus/comparison.h"
#include "tests/e2e/campus/pictured_rooms.h"
#include "tests/e2e/campus/trajectory_error.h"
#include "tests/e2e/whole_system.h"

namespace enfilade::testing {

struct LogRun {
  std::filesystem::path log;
  std::filesystem::path relations;     // for the errors; empty: none
  std::filesystem::path reference;     // a trajectory; used if there are no relations
  std::optional<PicturedRooms> rooms;  // to compare the maps with
  // The log's odometry is a corrected path: it becomes the reference, and the robot gets a copy of it with errors.
  bool simulate_odometry = false;
  std::uint64_t seed = 1;  // of these errors
  // The log's odometry runs ahead of its scans: the robot gets with each scan what the log has this many samples
  // before.
  int odometry_ahead = 0;
  std::vector<std::string> reading;  // options of `enfilade robot` and `enfilade slam` for reading the log
  std::filesystem::path keep;        // a folder for what is worth looking at; empty: nothing is kept
};

// One log that a robot recorded, mapped by `enfilade robot` into many maps, and by `enfilade slam` into one.
struct LogResult {
  std::string site;
  int maps = 0;
  int joins = 0;       // link points that join maps
  int candidates = 0;  // link points in one map
  int components = 0;  // pieces of the graph
  int sessions = 0;
  int passages = 0;  // that the robot reported
  int poses = 0;     // of the way in the world
  int left_out = 0;  // poses in maps without a place in the world
  double seconds = 0.0;
  double slam_seconds = 0.0;
  // Against relations or reference: of the way in the world, and of SLAM with one map. Unset: nothing to compare with.
  std::optional<TrajectoryError> error;
  std::optional<TrajectoryError> slam_error;
  // Of the way in the world against SLAM's trajectory.
  TrajectoryError difference;
  // The maps against the rooms that the robot entered. Poses are compared with SLAM's, link points are not. Unset: no
  // picture of the rooms is given.
  std::optional<Comparison> rooms;
  std::vector<std::string> verdicts;

  // Of the errors in metres.
  std::optional<double> ratio() const;
};

// Throws if a program fails.
LogResult RunLog(WholeSystem& system, const LogRun& run);

// Copies the log as JSON lines with an odometry that drifts: each step of d metres that turns by a rad has errors with
// standard deviations of 0.05 d along, and 3 deg * sqrt(d) + 0.02 a in yaw. Writes the log's own odometry into
// `reference`, lines "t x y yaw". Throws if the log cannot be read or has no odometry.
void SimulateOdometry(const LogRun& run, const std::filesystem::path& log, const std::filesystem::path& reference);

// Copies the log as JSON lines, with the pose that the sample `samples` before has in each sample of odometry. The
// first ones keep the first pose. Throws as above.
void DelayOdometry(const std::filesystem::path& log, int samples, const std::filesystem::path& copy);

}  // namespace enfilade::testing
