// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/simulator/world/world.h"
#include "core/base/noise.h"
#include "core/geometry/pose2.h"
#include "core/sensor/laser_scan.h"

namespace enfilade::simulator {

// Where a robot is when its sensors take a reading.
struct Viewpoint {
  const World& world;
  std::string level;
  Pose2 T_campus_robot;
  double seconds = 0.0;  // since the start: decides where the people are
  int gate = -1;         // the lift in which it rides, or -1
};

struct ScannerOptions {
  int beams = 720;
  double field_of_view = 2.0 * M_PI;  // rad; the last beam of a full turn lies one step before the first
  double range_min = 0.05;            // m
  double range_max = 100.0;           // m
  double range_sigma = 0.01;          // m
  double dropout = 0.002;             // share of beams that are NaN
  double height = 0.6;                // m above the floor
  Pose2 T_robot_laser{0.1, 0.0, 0.0};

  absl::Status Validate() const;
};

// A planar scan; +infinity beyond range_max. Glass reflects only near its normal.
sensor::LaserScan ReadScan(const Viewpoint& view, const ScannerOptions& options, Noise noise);

// A scanner with several rings, such as the VLP-16.
struct CloudScannerOptions {
  int rings = 16;
  double lowest = -15.0 * M_PI / 180.0;  // rad, of the first ring
  double step = 2.0 * M_PI / 180.0;      // rad between rings
  int azimuths = 900;
  double range_max = 100.0;  // m
  double range_sigma = 0.02;
  double dropout = 0.002;  // share of points that are missing
  double height = 1.1;     // m above the floor
  Pose2 T_robot_scanner{0.0, 0.0, 0.0};
};

// x y z of each return in the robot's frame (z up from the floor), metres, ring by ring within each azimuth.
std::vector<float> ReadCloud(const Viewpoint& view, const CloudScannerOptions& options, Noise noise);

struct CameraOptions {
  int width = 512;
  int height = 384;
  double field_of_view = 75.0 * M_PI / 180.0;  // rad, horizontal
  double mount_height = 1.0;                   // m above the floor
  Pose2 T_robot_camera{0.15, 0.0, 0.0};        // the optical axis along x
  double noise = 2.0;                          // grey levels
  double depth_max = 10.0;                     // m; no depth (0) beyond
  double depth_sigma = 0.002;                  // m, of the depth error at 1 m; it grows with the square of the depth

  double focal_length() const { return width / (2.0 * std::tan(field_of_view / 2.0)); }  // pixels
  absl::Status Validate() const;
};

struct CameraFrame {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> grey;
  std::vector<std::uint16_t> depth;  // mm along the optical axis, 0 unknown

  absl::StatusOr<std::string> GreyPng() const;
  absl::StatusOr<std::string> DepthPng() const;  // 16 bit
};

// The image of a pinhole camera with the principal point at its centre.
CameraFrame ReadCamera(const Viewpoint& view, const CameraOptions& options, Noise noise);

// The brightness (0 to 1) of a painted surface at (u, v), m. Detail smaller than a pixel, which covers `footprint` m of
// the surface, is left out.
float BrightnessOf(const Paint& paint, double u, double v, double footprint);

}  // namespace enfilade::simulator
