// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>

#include "absl/status/status.h"

namespace enfilade::server {

// For an error that will be over soon: when to try again.
absl::Status WithRetryHint(absl::Status status, std::chrono::milliseconds after);
std::optional<std::chrono::milliseconds> RetryHintOf(const absl::Status& status);

}  // namespace enfilade::server
