// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>

#include "absl/status/status.h"
#include "client/robot/agent.h"
#include "client/robot/line_input.h"
#include "client/robot/news.h"
#include "client/robot/sources.h"
#include "client/robot/uploader.h"

namespace enfilade::robot {

struct RunOptions {
  std::optional<double> rate;  // 1: as recorded; unset: as fast as it goes
  bool live = false;           // the source goes on by itself: it is not held up in the main menu
  bool wait = false;           // at the end, until the server has mapped and judged all
  double status_s = 5.0;       // between two reports of the state
  Eigen::Matrix3d pose_covariance = Eigen::Matrix3d::Zero();  // of a pose that a command gives without one
};

// Gives the agent what comes from `source` and from `commands` (may be null: nobody is there) until both it and the
// uploader are done. CANCELLED where `interrupted` says so: what is recorded is kept in the spool. FAILED_PRECONDITION
// where the server does not take a session for good.
absl::Status Run(Agent& agent, Uploader& uploader, Source& source, LineInput* commands, const RunOptions& options,
                 const std::function<bool()>& interrupted, const NewsListener& listener);

}  // namespace enfilade::robot
