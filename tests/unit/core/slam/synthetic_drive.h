// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/pose2.h"
#include "core/sensor/scan_pairing.h"

namespace enfilade::testing {

// A wall between two points of the world, m.
struct Wall {
  Eigen::Vector2d a;
  Eigen::Vector2d b;
};

struct SyntheticScanner {
  int beams = 180;
  double field_of_view = 3.14159265358979323846;  // rad, centred on the robot's heading
  double range_max = 20.0;                        // m
  double range_sigma = 0.01;                      // m, of the ranges' noise
};

struct SyntheticOdometry {
  double translation_share = 0.0;  // error per metre, standard deviation
  double yaw_per_metre = 0.0;      // rad per metre
};

// What the scanner sees of `walls` from `T_world_robot`. The noise is drawn from `seed`.
sensor::LaserScan Scan(const std::vector<Wall>& walls, const Pose2& T_world_robot, const SyntheticScanner& scanner,
                       TimeNs time, std::uint64_t seed);

// Poses along straight lines through `corners`, `step` (m) apart, turning on the spot at corners by steps of 0.2 rad.
std::vector<Pose2> Drive(const std::vector<Eigen::Vector2d>& corners, double step);

// One scan per pose, 0.5 s apart, sequences from 1; odometry in the robot's first frame with errors drawn from `seed`.
std::vector<sensor::PairedScan> Record(const std::vector<Wall>& walls, const std::vector<Pose2>& poses,
                                       const SyntheticScanner& scanner, const SyntheticOdometry& odometry,
                                       std::uint64_t seed);

// The walls drawn with '#' in rows of text, top row first, each character `cell` metres wide; the lower-left character
// has its lower-left corner at the origin.
std::vector<Wall> WallsFromText(const std::vector<const char*>& rows, double cell);

}  // namespace enfilade::testing
