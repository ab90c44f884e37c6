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

// What a drive came to.
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

// A campus by the name of a shipped one, "random:SEED" for a random building, or the path of a YAML file. NOT_FOUND
// where it is none of these.
absl::StatusOr<Campus> LoadCampus(const std::string& name);

// Drives one robot and writes `folder`: log.jsonl (docs/logs.md) with images and clouds beside it, truth.jsonl
// (docs/simulator.md) and truth.txt (lines "t x y yaw"). FAILED_PRECONDITION where a file cannot be written.
absl::StatusOr<DriveReport> WriteDrive(std::shared_ptr<const World> world, const std::string& robot,
                                       const SimulationOptions& options, const std::filesystem::path& folder);

// The ground truth's lines.
std::string TruthLines(const GroundTruth& truth);
std::string TruthTrajectory(const GroundTruth& truth);  // "t x y yaw", as `enfilade trajectory export`

// The mounts and intrinsics of the sensors as JSON, which logs have no room for.
std::string SensorDescription(const SimulationOptions& options);

}  // namespace enfilade::simulator
