// SPDX-License-Identifier: Apache-2.0
#include "server/app/runtime/retry_hint.h"

#include <cstdint>
#include <string>

#include "absl/strings/cord.h"
#include "absl/strings/numbers.h"

namespace enfilade::server {
namespace {

constexpr char kRetryAfterMs[] = "enfilade/retry-after-ms";

}  // namespace

absl::Status WithRetryHint(absl::Status status, std::chrono::milliseconds after) {
  status.SetPayload(kRetryAfterMs, absl::Cord(std::to_string(after.count())));
  return status;
}

std::optional<std::chrono::milliseconds> RetryHintOf(const absl::Status& status) {
  const auto payload = status.GetPayload(kRetryAfterMs);
  std::int64_t count = 0;
  if (!payload || !absl::SimpleAtoi(std::string(*payload), &count)) return std::nullopt;
  return std::chrono::milliseconds(count);
}

}  // namespace enfilade::server
