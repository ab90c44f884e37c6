// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/rearrange/plan.h"
#include "server/app/graph/site_graphs.h"
#include "server/app/rearrange/rearranger.h"
#include "storage/call_context.h"
#include "storage/graph/site_lease_store.h"

namespace enfilade::server {

// Merges and splits maps when people ask for it: waits for the site's lease, decides by the present graph
// (core/rearrange/plan.h), and applies it; decides again if the graph has changed meanwhile. Thread-safe.
class MapRearrangements {
 public:
  // All must outlive it. `map_name`: the prefix of new maps' display names.
  MapRearrangements(const Rearranger::Stores& stores, const storage::SiteLeaseStore& leases,
                    const Rearranger& rearranger, SiteGraphs& graphs, std::string map_name);

  struct Merge {
    MapId kept;
    MapId merged;
    std::optional<Pose2> T_kept_merged;  // unset: by the graph
  };
  // Errors: rearrange::PlanMerge, Rearranger::Apply; FAILED_PRECONDITION if one of the maps was merged into another
  // one; ABORTED if another process keeps the lease until the deadline, or the graph keeps changing.
  absl::StatusOr<storage::StoredRearrangement> Apply(const storage::CallContext& context, const SiteId& site,
                                                     const Merge& merge) const;

  struct Split {
    MapId map;
    std::vector<SessionId> leaving;
    std::vector<rearrange::SessionCut> cuts;
    MapId new_map;
  };
  absl::StatusOr<storage::StoredRearrangement> Apply(const storage::CallContext& context, const SiteId& site,
                                                     const Split& split) const;

  absl::StatusOr<storage::StoredRearrangement> Undo(const storage::CallContext& context, const SiteId& site,
                                                    const rearrange::RearrangementId& id) const;

 private:
  using Plan = std::function<absl::StatusOr<rearrange::Rearrangement>(const graph::GraphSnapshot& graph)>;

  absl::StatusOr<storage::StoredRearrangement> PlanAndApply(const storage::CallContext& context, const SiteId& site,
                                                            const Plan& plan) const;
  absl::StatusOr<rearrange::MapContent> ReadContent(const storage::CallContext& context, const SiteId& site,
                                                    const MapId& map, bool with_keyframes) const;

  const Rearranger::Stores stores_;
  const storage::SiteLeaseStore& leases_;
  const Rearranger& rearranger_;
  SiteGraphs& graphs_;
  const std::string map_name_;
  const std::string owner_;
};

}  // namespace enfilade::server
