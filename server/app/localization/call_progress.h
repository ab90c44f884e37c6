// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

#include "absl/status/status.h"
#include "storage/call_context.h"

namespace enfilade::server {

// For work that takes long: CANCELLED or DEADLINE_EXCEEDED once nobody waits for the call any more.
inline absl::Status CheckProgress(const storage::CallContext& context) {
  if (context.cancellation.stop_requested()) return absl::CancelledError("the call was cancelled");
  if (std::chrono::steady_clock::now() >= context.deadline) {
    return absl::DeadlineExceededError("the call's deadline has passed");
  }
  return absl::OkStatus();
}

}  // namespace enfilade::server
