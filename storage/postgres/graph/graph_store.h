// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "storage/graph/graph_store.h"
#include "storage/postgres/driver/pool.h"

namespace enfilade::storage::postgres {

class GraphStore final : public storage::GraphStore {
 public:
  explicit GraphStore(Pool& pool) : pool_(pool) {}

  absl::StatusOr<std::int64_t> GetVersion(const CallContext& context, const SiteId& site) const override;
  absl::StatusOr<GraphChanges> ReadChanges(const CallContext& context, const SiteId& site,
                                           std::int64_t since) const override;
  absl::StatusOr<std::int64_t> Apply(const CallContext& context, const SiteId& site, std::int64_t version,
                                     const GraphSolution& solution) const override;
  absl::StatusOr<std::int64_t> SolveHeld(
      const CallContext& context, const SiteId& site, std::int64_t since,
      const std::function<absl::StatusOr<GraphSolution>(const GraphChanges&)>& solve) const override;
  absl::StatusOr<std::vector<GraphVersion>> ListVersions(const CallContext& context, const SiteId& site,
                                                         std::int64_t before, int limit) const override;
  absl::StatusOr<std::int64_t> FindLastOptimization(const CallContext& context, const SiteId& site,
                                                    std::int64_t since) const override;
  absl::StatusOr<MapPoseChanges> GetMapPoses(const CallContext& context, const SiteId& site, std::int64_t version,
                                             std::int64_t since) const override;
  absl::StatusOr<std::vector<MapPose>> GetPlaces(const CallContext& context, const SiteId& site,
                                                 const std::vector<MapId>& maps) const override;
  absl::StatusOr<std::int64_t> SetControlPoints(const CallContext& context, const SiteId& site,
                                                const std::vector<ControlPoint>& points) const override;
  absl::StatusOr<std::vector<ControlPoint>> GetControlPoints(const CallContext& context,
                                                             const SiteId& site) const override;
  absl::StatusOr<std::vector<StoredPlanTies>> ReadPlanTies(const CallContext& context, const SiteId& site,
                                                           const std::vector<std::string>& known) const override;
  absl::StatusOr<std::vector<storage::GraphListener::Change>> ListVersionsOf(
      const CallContext& context, const std::vector<SiteId>& sites) const override;
  absl::StatusOr<std::unique_ptr<storage::GraphListener>> Listen(const CallContext& context) const override;

 private:
  Pool& pool_;
};

}  // namespace enfilade::storage::postgres
