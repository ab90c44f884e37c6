// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "storage/call_context.h"
#include "storage/graph/site_lease_store.h"

namespace enfilade::storage {

// A site with sessions that no survey has seen.
struct PendingSurvey {
  SiteId site;
  std::int64_t sessions = 0;  // that are mapped and judged, and that no survey has seen
  // A robot that has recorded some of them has recorded none for a second, and all of its are mapped.
  bool drive_ended = false;
  // Sessions of the site have waited for two seconds to be mapped, or for the verdict that gives them their map.
  bool mapping_lags = false;

  friend bool operator==(const PendingSurvey&, const PendingSurvey&) = default;
};

// Which sessions a survey of their site has seen since they were mapped (server/app/survey). Thread-safe; errors common
// to all stores: see SiteStore.
class SurveyStore {
 public:
  virtual ~SurveyStore() = default;

  // The one that has waited longest first.
  virtual absl::StatusOr<std::vector<PendingSurvey>> FindPending(const CallContext& context) const = 0;
  // Sessions that do not exist are ignored. ABORTED if the lease is lost.
  virtual absl::Status MarkSurveyed(const CallContext& context, const SiteLease& lease,
                                    const std::vector<SessionId>& sessions) const = 0;
};

}  // namespace enfilade::storage
