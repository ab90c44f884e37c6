// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "absl/status/status.h"
#include "client/cli/command.h"
#include "client/cli/log_options.h"

namespace enfilade::cli {

// A robot that is to be located in a plan of the site, by a log or by a session.
struct LocateInStoredPlanOptions {
  std::string plan;  // its name, id or resource name
  std::string log;
  sources::LogOptions reading;
  std::string session;  // id or resource name
  std::string pairs;    // a file, as of `prior locate`
};

// Asks the server, and prints what it says. INVALID_ARGUMENT: neither a log nor a session, or both; NOT_FOUND: no such
// plan; errors of LocateInPriorMap.
absl::Status LocateInStoredPlan(const Globals& globals, const LocateInStoredPlanOptions& options);

}  // namespace enfilade::cli
