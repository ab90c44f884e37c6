// SPDX-License-Identifier: Apache-2.0
#include "storage/sessions/mapping_store.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/resource_name.h"

namespace enfilade::storage {

bool IsToBeMapped(const Session& session, std::int64_t read_sequence) {
  if (!session.map) return false;
  if (session.state == SessionState::kFinished) return true;
  return session.state == SessionState::kRecording &&
         session.acknowledged_sequence > std::max(session.mapped_sequence, read_sequence);
}

absl::Status ValidateStep(const SessionLease& lease, const MappingProgress& progress, const MappingStep& step) {
  if (step.mapped_sequence < progress.mapped_sequence) {
    return InvalidArgument("mapping of {} has reached record {} and cannot go back to {}",
                           NameOf(lease.site, lease.session), progress.mapped_sequence, step.mapped_sequence);
  }
  if (!step.final_state) return absl::OkStatus();
  if (*step.final_state != SessionState::kMapped && *step.final_state != SessionState::kFailed) {
    return InvalidArgument("the final state {} is neither mapped nor failed", static_cast<int>(*step.final_state));
  }
  const bool closed = progress.state == SessionState::kFinished || progress.state == *step.final_state;
  if (*step.final_state == SessionState::kMapped && !closed) {
    return FailedPrecondition("{} is not finished: more records may come", NameOf(lease.site, lease.session));
  }
  return absl::OkStatus();
}

absl::Status LeaseLost(const SessionLease& lease) {
  return Aborted("{} has lost the lease on {}", lease.owner, NameOf(lease.site, lease.session));
}

}  // namespace enfilade::storage
