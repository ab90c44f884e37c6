// SPDX-License-Identifier: Apache-2.0
#include "server/app/closure/judging_lease.h"

#include <chrono>

#include "core/base/status_macros.h"

namespace enfilade::server {
namespace {

// Of one store call. Judging a report as a whole has no limit: on a slow machine it would start over again and again.
constexpr auto kJudgingTimeout = std::chrono::seconds(60);

}  // namespace

storage::CallContext JudgingLease::Context() {
  storage::CallContext context = storage::CallContext::WithTimeout(kJudgingTimeout);
  context.actor = "closure at a door";
  return context;
}

absl::Status JudgingLease::Renew() const {
  if (stop_.is_set()) return absl::CancelledError("the server is stopping");
  const Clock::time_point begin = now_();
  if (begin - renewed_ < kTime / 4) return absl::OkStatus();
  ENFILADE_RETURN_IF_ERROR(leases_.Renew(Context(), lease_, kTime));
  renewed_ = begin;
  return absl::OkStatus();
}

}  // namespace enfilade::server
