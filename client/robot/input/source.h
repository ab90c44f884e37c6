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
#include "client/robot/agent/state_machine.h"
#include "client/robot/input/line_reader.h"
#include "client/robot/input/pose_report.h"
#include "client/sdk/spool/spool.h"
#include "client/simulator/simulation.h"
#include "client/sources/log_reader.h"

namespace enfilade::robot {

// A line that could not be read; the source continues with the next one.
struct BadInput {
  std::string message;  // with the line's number
};

// No input at the moment.
struct Idle {};
// No more input.
struct Ended {};

using Input = std::variant<client::SpoolItem, Command, PoseReport, BadInput, Idle, Ended>;

// Where an agent's input comes from. Not thread-safe.
class Source {
 public:
  virtual ~Source() = default;
  // Waits about 100 ms at most for input. An error ends the source for good.
  virtual absl::StatusOr<Input> Next() = 0;
};

// A recorded log. A line that cannot be read ends it, or is skipped with LogOptions::skip_bad_lines.
absl::StatusOr<std::unique_ptr<Source>> OpenLog(const std::string& path, const sources::LogOptions& options);

// A drive through a simulated campus. `truth`: the file to which the ground truth is written at the end
// (docs/simulator.md); empty: none.
absl::StatusOr<std::unique_ptr<Source>> OpenSimulation(const std::string& campus, const std::string& robot,
                                                       const simulator::SimulationOptions& options, std::string truth);

// JSON lines read from `fd`: records as in docs/logs.md with files relative to `folder`, commands and pose reports
// (docs/robot.md). `covariance`: of poses without one. A line that cannot be read is a BadInput.
std::unique_ptr<Source> OpenLines(int fd, const std::filesystem::path& folder, const Eigen::Matrix3d& covariance);

}  // namespace enfilade::robot
