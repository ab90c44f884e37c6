// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "absl/status/statusor.h"
#include "client/robot/line_input.h"
#include "client/robot/own_pose.h"
#include "client/robot/state_machine.h"
#include "client/sdk/spool/spool.h"
#include "client/simulator/simulation.h"
#include "client/sources/log_reader.h"

namespace enfilade::robot {

// A line that could not be read; the source goes on behind it.
struct BadInput {
  std::string message;  // with the line's number
};

// Nothing at the moment.
struct Idle {};
// Nothing more at all.
struct Ended {};

using Input = std::variant<client::SpoolItem, Command, OwnPose, BadInput, Idle, Ended>;

// What a robot's agent listens to. Not thread-safe.
class Source {
 public:
  virtual ~Source() = default;
  // Waits at most about 100 ms for something to come. Errors: what ends the source for good.
  virtual absl::StatusOr<Input> Next() = 0;
};

// A recorded log, whose lines that cannot be read end it or are passed over (LogOptions::skip_bad_lines).
absl::StatusOr<std::unique_ptr<Source>> OpenLog(const std::string& path, const sources::LogOptions& options);

// A drive through a simulated campus. `truth`: a file that gets the ground truth at the end (docs/simulator.md); may be
// empty.
absl::StatusOr<std::unique_ptr<Source>> OpenSimulation(const std::string& campus, const std::string& robot,
                                                       const simulator::SimulationOptions& options, std::string truth);

// JSON lines as they come in on `fd`: those of docs/logs.md with files relative to `folder`, commands and poses of the
// robot's own (docs/robot.md). A line that cannot be read is a BadInput.
std::unique_ptr<Source> OpenLines(int fd, std::filesystem::path folder, const Eigen::Matrix3d& covariance);

}  // namespace enfilade::robot
