// SPDX-License-Identifier: Apache-2.0
#include "client/robot/agent/start_location.h"

#include <utility>

#include "client/sdk/api/localization.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "proto/convert/geometry.h"
#include "proto/convert/names.h"

namespace enfilade::robot {
namespace {

// The server may answer later.
bool IsPassing(const absl::Status& status) {
  return absl::IsUnavailable(status) || absl::IsDeadlineExceeded(status) || absl::IsResourceExhausted(status);
}

}  // namespace

LocateByScans LocateOnServer(const client::Connection& connection, const SiteId& site) {
  return [connection, site](const std::vector<sensor::PairedScan>& scans) -> absl::StatusOr<StartAnswer> {
    ENFILADE_ASSIGN_OR_RETURN(const v1::LocalizeRobotResponse response, client::LocalizeRobot(connection, site, scans));
    StartAnswer answer;
    answer.hypotheses = response.poses_size();
    answer.maps_searched = response.maps_searched();
    answer.reason = response.reason();
    if (response.poses().empty()) return answer;
    const v1::LocatedPose& best = response.poses(0);
    ENFILADE_ASSIGN_OR_RETURN(const convert::MapName map, convert::ParseMapName("poses[0].map", best.map()));
    ENFILADE_ASSIGN_OR_RETURN(answer.T_map_robot, convert::FromProto("poses[0].pose_map_robot", best.pose_map_robot()));
    answer.map = map.map.value();
    answer.confident = best.confident();
    return answer;
  };
}

bool StartLocation::Add(const sensor::PairedScan& scan) { return recent_.Add(scan) && !decision_; }

std::vector<sensor::PairedScan> StartLocation::scans() const {
  std::vector<sensor::PairedScan> scans;
  for (const localization::QueryScan& scan : recent_.scans()) scans.push_back({0, scan.scan, scan.T_odom_robot});
  return scans;
}

void StartLocation::Answer(const absl::StatusOr<StartAnswer>& answer, const Pose2& T_odom_robot) {
  if (decision_) return;
  if (!answer.ok()) {
    reason_ = std::string(answer.status().message());
    if (IsPassing(answer.status())) {
      recent_.Retry();
    } else if (!absl::IsInvalidArgument(answer.status())) {  // that the scans show no walls may change
      decision_ = StartDecision{{}, {}, {}, reason_};
    }
    return;
  }
  reason_ = answer->hypotheses > 1 ? fmt::format("{} places are possible; {}", answer->hypotheses, answer->reason)
                                   : answer->reason;
  if (answer->confident) {
    decision_ = StartDecision{answer->map, answer->T_map_robot, T_odom_robot, answer->reason};
  } else if (answer->maps_searched == 0) {
    decision_ = StartDecision{{}, {}, {}, answer->reason};
  }
}

std::optional<StartDecision> StartLocation::Decide() const {
  if (decision_) return decision_;
  if (recent_.travelled() < options_.distance && recent_.seconds() < options_.time) return std::nullopt;
  return DecideNow();
}

StartDecision StartLocation::DecideNow() const { return decision_.value_or(StartDecision{{}, {}, {}, reason_}); }

}  // namespace enfilade::robot
