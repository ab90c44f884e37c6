// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>

#include "absl/status/status.h"
#include "client/robot/agent/agent.h"
#include "client/robot/input/line_reader.h"
#include "client/robot/input/source.h"
#include "client/robot/notification.h"
#include "client/robot/upload/uploader.h"

namespace enfilade::robot {

struct RunOptions {
  std::optional<double> rate;  // 1: as recorded; unset: as fast as possible
  bool live = false;           // the source cannot be paused: it is read in the main menu, too
  bool wait = false;           // at the end, wait until the server has mapped and judged everything
  double status_s = 5.0;       // between two status reports
  Eigen::Matrix3d pose_covariance = Eigen::Matrix3d::Zero();  // of a pose that a command gives without one
};

// What a run works with. All references must outlive it.
struct RunContext {
  Agent& agent;
  Uploader& uploader;
  Source& source;
  LineReader* commands = nullptr;  // null: there is nobody to give commands
  std::function<bool()> interrupted;
  NotificationListener listener;
};

// Passes the input of `source` and `commands` to the agent until both the agent and the uploader are done. CANCELLED:
// interrupted; what was recorded stays in the spool. FAILED_PRECONDITION: the server refuses a session for good.
absl::Status Run(const RunContext& context, const RunOptions& options);

}  // namespace enfilade::robot
