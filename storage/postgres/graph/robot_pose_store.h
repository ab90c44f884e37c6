// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "storage/graph/robot_pose_store.h"
#include "storage/postgres/driver/pool.h"

namespace enfilade::storage::postgres {

class RobotPoseStore final : public storage::RobotPoseStore {
 public:
  explicit RobotPoseStore(Pool& pool) : pool_(pool) {}

  std::vector<absl::Status> ReportAll(const CallContext& context, const std::vector<RobotPose>& poses) const override;
  absl::StatusOr<RobotPose> Get(const CallContext& context, const SiteId& site, const RobotId& robot) const override;
  absl::StatusOr<std::vector<RobotPose>> List(const CallContext& context, const SiteId& site) const override;

 private:
  Pool& pool_;
};

}  // namespace enfilade::storage::postgres
