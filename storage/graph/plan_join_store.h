// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/rearrange/rearrangement.h"
#include "storage/call_context.h"

namespace enfilade::storage {
namespace postgres {
class Pool;
}

// A link point that was made of candidates of two maps because a plan has a door there (Rearrangement::plan), or what a
// person has undone of that.
struct PlanJoin {
  rearrange::RearrangementId rearrangement;
  PriorMapId plan;
  LinkPointId link_point;
  std::vector<LinkPointId> candidates;  // that it replaced
  std::string reason;
  bool undone = false;  // by a person
  bool passed = false;  // a robot has driven through the door since
};

struct SiteWithPlans {
  SiteId site;
  std::int64_t graph_version = 0;
};

// Link points that doors of plans have made. They are rearrangements; this is who asks for them in another order.
// Thread-safe; errors common to all stores: see SiteStore.
class PlanJoinStore {
 public:
  explicit PlanJoinStore(postgres::Pool& pool) : pool_(pool) {}

  // Sites with a plan in use, or with a join whose link point exists; by id.
  absl::StatusOr<std::vector<SiteWithPlans>> ListSites(const CallContext& context) const;
  // Those whose link point exists, and those that people have undone, the latest first. Without those that were
  // withdrawn.
  absl::StatusOr<std::vector<PlanJoin>> List(const CallContext& context, const SiteId& site) const;
  // Tells that an undone join was undone because its plan is no longer in use: it may be made again.
  absl::Status MarkWithdrawn(const CallContext& context, const SiteId& site,
                             const rearrange::RearrangementId& id) const;

 private:
  postgres::Pool& pool_;
};

}  // namespace enfilade::storage
