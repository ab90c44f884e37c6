// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "server/config/server_options.h"

namespace enfilade::server {

// Sets spdlog's default logger to the options' level and format (JSON: one object per line with time, level, message)
// on standard error, and sends gRPC's own messages there.
void SetUpLogging(const ServerOptions::Log& options);

}  // namespace enfilade::server
