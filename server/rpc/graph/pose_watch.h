// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <set>
#include <string>

#include "absl/status/statusor.h"
#include "enfilade/v1/graph_service.pb.h"
#include "server/app/services.h"
#include "storage/call_context.h"

namespace enfilade::server {

// What one watcher of global poses has been told, and what is new since. Not thread-safe.
class PoseWatch {
 public:
  // INVALID_ARGUMENT naming the field.
  static absl::StatusOr<PoseWatch> Create(const v1::WatchGlobalPosesRequest& request);

  // Between two looks.
  std::chrono::steady_clock::duration period() const { return period_; }

  // Writes what has changed since the last look into `response`. False where nothing has, except at the first look:
  // its answer tells graph version and resume token, if nothing else. NOT_FOUND: no such site or robot.
  absl::StatusOr<bool> Check(const Services& services, const storage::CallContext& context,
                             v1::WatchGlobalPosesResponse& response);

 private:
  struct Token {
    std::int64_t graph_version = 0;
    std::int64_t report_version = 0;  // the greatest
  };
  struct Sent {
    std::int64_t report_version = 0;
    std::string pose;  // the message's pose_world_robot, as bytes
  };

  static absl::StatusOr<Token> ParseToken(const std::string& token);
  absl::Status CheckRobots(const Services& services, const storage::CallContext& context) const;
  bool IsNew(const storage::RobotPose& report, std::int64_t graph_version, const v1::GlobalPose& pose);

  SiteId site_;
  std::set<RobotId> robots_;  // empty: all
  std::chrono::steady_clock::duration period_{};
  Token token_;
  std::map<RobotId, Sent> sent_;
  bool first_ = true;
};

}  // namespace enfilade::server
