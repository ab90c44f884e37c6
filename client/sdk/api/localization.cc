// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/api/localization.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/base/error.h"
#include "enfilade/v1/localization_service.grpc.pb.h"
#include "proto/convert/record.h"

namespace enfilade::client {
namespace {

constexpr double kSpacing = 0.25;  // m, rad

// The last scan, and earlier ones with odometry far enough from the one after them.
std::vector<const sensor::PairedScan*> Apart(const std::vector<sensor::PairedScan>& scans, std::size_t most) {
  std::vector<const sensor::PairedScan*> apart;
  for (auto it = scans.rbegin(); it != scans.rend() && apart.size() < most; ++it) {
    if (!apart.empty()) {
      if (!it->T_odom_robot || !apart.back()->T_odom_robot) break;
      const Pose2 motion = Between(*apart.back()->T_odom_robot, *it->T_odom_robot);
      if (motion.translation().norm() < kSpacing && std::abs(motion.yaw) < kSpacing) continue;
    }
    apart.push_back(&*it);
  }
  std::reverse(apart.begin(), apart.end());
  return apart;
}

void SetScan(const sensor::PairedScan& scan, v1::LocalizationScan& sent) {
  convert::ToProto(scan.scan, *sent.mutable_scan());
  if (scan.T_odom_robot) *sent.mutable_pose_odom_robot() = convert::ToProto(*scan.T_odom_robot);
}

}  // namespace

v1::LocalizeRobotRequest MakeLocalizeRequest(const SiteId& site, const std::vector<sensor::PairedScan>& scans) {
  v1::LocalizeRobotRequest request;
  request.set_site("sites/" + site.value());
  for (const sensor::PairedScan* scan : Apart(scans, kMaxLocalizationScans)) SetScan(*scan, *request.add_scans());
  return request;
}

v1::LocateInPriorMapRequest MakeLocateInPriorMapRequest(const std::string& name,
                                                        const std::vector<sensor::PairedScan>& scans) {
  v1::LocateInPriorMapRequest request;
  request.set_name(name);
  for (const sensor::PairedScan* scan : Apart(scans, kMaxPlanScans)) SetScan(*scan, *request.add_scans());
  return request;
}

absl::StatusOr<v1::LocalizeRobotResponse> LocalizeRobot(const Connection& connection, const SiteId& site,
                                                        const std::vector<sensor::PairedScan>& scans,
                                                        const v1::LocalizationPrior& prior) {
  if (scans.empty()) return InvalidArgument("there are no scans to locate the robot by");
  v1::LocalizeRobotRequest request = MakeLocalizeRequest(site, scans);
  *request.mutable_prior() = prior;
  return connection.Call(&v1::LocalizationService::Stub::LocalizeRobot, request);
}

}  // namespace enfilade::client
