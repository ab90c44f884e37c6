// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/base/time.h"
#include "storage/call_context.h"
#include "storage/request_id.h"

namespace enfilade::storage {
namespace postgres {
class Pool;
}

struct Robot {
  SiteId site;
  RobotId id;
  std::string display_name;
  // Set by the store.
  std::int64_t etag = 0;
  TimeNs create_time = 0;
  TimeNs update_time = 0;
};

// Thread-safe; errors common to all stores: see SiteStore.
class RobotStore {
 public:
  explicit RobotStore(postgres::Pool& pool) : pool_(pool) {}

  // ALREADY_EXISTS; NOT_FOUND if the site does not exist. `request_id` as in SiteStore.
  absl::StatusOr<Robot> Create(const CallContext& context, const Robot& robot, const RequestId& request_id) const;
  absl::StatusOr<Robot> Get(const CallContext& context, const SiteId& site, const RobotId& robot) const;
  absl::StatusOr<std::vector<Robot>> List(const CallContext& context, const SiteId& site,
                                          const PageRequest& page) const;
  // Writes the display name. ABORTED on a stale `robot.etag`, NOT_FOUND.
  absl::StatusOr<Robot> Update(const CallContext& context, const Robot& robot) const;
  // FAILED_PRECONDITION while the robot has sessions; ABORTED on a stale `etag` (0: any); NOT_FOUND.
  absl::Status Delete(const CallContext& context, const SiteId& site, const RobotId& robot, std::int64_t etag) const;

 private:
  postgres::Pool& pool_;
};

}  // namespace enfilade::storage
