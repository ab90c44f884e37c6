// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/simulator/simulation.h"

namespace enfilade::simulator {

// A summary of a drive.
struct DriveReport {
  std::string robot;
  std::filesystem::path log;
  std::int64_t odometry = 0;
  std::int64_t scans = 0;
  std::int64_t images = 0;
  std::int64_t clouds = 0;
  double seconds = 0.0;  // of driving
  GroundTruth truth;
};

// A shipped campus by its name, a random building by "random:SEED", "suites:SEED" or "halls:SEED", a campus file by its
// path, or a building of Open-RMF by the path of its NAME.building.yaml. NOT_FOUND: it is none of these.
absl::StatusOr<Campus> LoadCampus(const std::string& name);

// Drives one robot and writes `folder`: log.jsonl (docs/logs.md) with images and clouds beside it, truth.jsonl
// (docs/simulator.md) and truth.txt (lines "t x y yaw"). FAILED_PRECONDITION: a file cannot be written.
absl::StatusOr<DriveReport> WriteDrive(std::shared_ptr<const World> world, const std::string& robot,
                                       const SimulationOptions& options, const std::filesystem::path& folder);

// The ground truth as text: truth.jsonl and truth.txt.
std::string TruthLines(const GroundTruth& truth);
std::string TruthTrajectory(const GroundTruth& truth);  // "t x y yaw", as `enfilade trajectory export`

// The mounts and intrinsics of the sensors as JSON; logs do not contain them.
std::string SensorDescription(const SimulationOptions& options);

}  // namespace enfilade::simulator
