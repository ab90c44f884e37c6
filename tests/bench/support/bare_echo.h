// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace enfilade::bench {

// The yardstick of global poses: a gRPC server that answers GetGlobalPose at once with the message in `file`. Serves at
// `address` until the process is killed.
void ServeBareEcho(const std::string& address, const std::string& file);

}  // namespace enfilade::bench
