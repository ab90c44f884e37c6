// SPDX-License-Identifier: Apache-2.0
#include "server/app/priors/plans_beside.h"

#include <string>

#include "core/base/status_macros.h"
#include "core/graph/plans/shared_walls.h"

namespace enfilade::server {
namespace {

constexpr int kPriorMapsPage = 1000;
constexpr double kSameArea = 0.3;  // of the shorter plan's walls

}  // namespace

absl::StatusOr<std::optional<graph::PlanTies>> ReadTies(const storage::CallContext& context,
                                                        const storage::PriorMapStore& prior_maps,
                                                        const storage::BlobStore& blobs, const SiteId& site,
                                                        const PriorMapId& id) {
  ENFILADE_ASSIGN_OR_RETURN(const auto files, prior_maps.ListFiles(context, site, id));
  for (const storage::PriorMapFile& file : files) {
    if (file.product != storage::PriorMapProduct::kTies) continue;
    ENFILADE_ASSIGN_OR_RETURN(const std::string bytes, blobs.Get(context, site, file.sha256));
    ENFILADE_ASSIGN_OR_RETURN(graph::PlanTies ties, graph::DecodePlanTies(bytes));
    return ties;
  }
  return std::nullopt;
}

absl::StatusOr<PlansBeside> FindPlansBeside(const storage::CallContext& context,
                                            const storage::PriorMapStore& prior_maps, const storage::BlobStore& blobs,
                                            const storage::PriorMap& prior_map, const graph::PlanTies& ties) {
  PlansBeside beside;
  for (std::string after;;) {
    ENFILADE_ASSIGN_OR_RETURN(const auto page, prior_maps.List(context, prior_map.site, {kPriorMapsPage, after}));
    for (const storage::PriorMap& other : page) {
      const bool is_beside =
          other.id != prior_map.id && other.level == prior_map.level && other.state == storage::PriorMapState::kActive;
      if (!is_beside) continue;
      beside.etags.push_back(other.etag);
      if (beside.same_area) continue;
      ENFILADE_ASSIGN_OR_RETURN(const auto others, ReadTies(context, prior_maps, blobs, other.site, other.id));
      if (others && graph::ShareOfWalls(ties, *others) >= kSameArea) beside.same_area = other.id;
    }
    if (page.size() < kPriorMapsPage) return beside;
    after = page.back().id.value();
  }
}

}  // namespace enfilade::server
