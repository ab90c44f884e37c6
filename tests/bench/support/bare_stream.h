// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace enfilade::bench {

// The yardstick of downloads: a gRPC server that streams one file out of its memory in messages of 1 MiB, with the same
// message type. Serves at `address` until the process is killed.
void ServeBareStream(const std::string& address, const std::string& file);

}  // namespace enfilade::bench
