// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "storage/call_context.h"
#include "storage/graph/site_lease_store.h"

namespace enfilade::storage {

// Which sessions a survey of their site has seen since they were mapped (server/app/survey). Thread-safe; errors common
// to all stores: see SiteStore.
class SurveyStore {
 public:
  virtual ~SurveyStore() = default;

  // Sites with sessions that are mapped, whose doors are judged and that no survey has seen: the one that has waited
  // longest first.
  virtual absl::StatusOr<std::vector<SiteId>> FindPending(const CallContext& context, int limit) const = 0;
  // Sessions that do not exist are ignored. ABORTED if the lease is lost.
  virtual absl::Status MarkSurveyed(const CallContext& context, const SiteLease& lease,
                                    const std::vector<SessionId>& sessions) const = 0;
};

}  // namespace enfilade::storage
