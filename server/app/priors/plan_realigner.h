// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "server/app/priors/prior_alignment.h"
#include "server/app/runtime/maintenance_loop.h"
#include "storage/call_context.h"
#include "storage/maps/prior_map_store.h"

namespace enfilade::server {

// Aligns plans in use again when robots have mapped more since. A plan that no longer fits becomes DIVERGED, as it does
// when a person aligns it. Of several server processes the one that is done first stores what it has found.
class PlanRealigner {
 public:
  // A plan is not aligned again before `interval` has passed, whatever became of the last time.
  PlanRealigner(const storage::PriorMapStore& store, const PriorAlignment& alignment, std::chrono::seconds interval)
      : store_(store), alignment_(alignment), interval_(interval) {}

  // Aligns at most one plan, the one that was aligned first, and returns how many it has aligned. Not thread-safe.
  absl::StatusOr<std::int64_t> AlignOne(const storage::CallContext& context);

  // As a job of a MaintenanceLoop, which this must outlive.
  MaintenanceJob Job();

 private:
  using Clock = std::chrono::steady_clock;

  absl::Status Align(const storage::PriorMap& prior_map) const;

  const storage::PriorMapStore& store_;
  const PriorAlignment& alignment_;
  const std::chrono::seconds interval_;
  std::map<std::pair<SiteId, PriorMapId>, Clock::time_point> tried_;
};

}  // namespace enfilade::server
