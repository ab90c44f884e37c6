// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "server/config/server_options.h"

namespace enfilade::server {

// Makes spdlog's default logger write to standard error with the options' level and format (JSON: one object per line
// with time, level, thread and message; text: one line each, control characters escaped), and redirects gRPC's own log
// to it.
void SetUpLogging(const ServerOptions::Log& options);

}  // namespace enfilade::server
